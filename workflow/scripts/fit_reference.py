"""Mean shape of the points over the training utterances, and the grid of pixels inside it."""

from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.face.aam.reference import ReferenceSettings, fit_reference_of
from visualspeech.face.point_sets import read_point_set
from visualspeech.jobs import job
from visualspeech.storage.arrays import ArrayCollection

with job(snakemake.log[0]), ArrayCollection(snakemake.input.pose) as pose:
    training = [one.id for one in of_split(read_utterances(snakemake.input.utterances), "train")]
    points, settings = read_point_set(snakemake.params.points), ReferenceSettings(**snakemake.params.settings)
    fit_reference_of(pose, training, points, settings).save(snakemake.output[0])
