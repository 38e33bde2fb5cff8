"""Mean shape of the lower face over the training utterances, and the grid of pixels inside it."""

from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.face.aam.points import lower_face
from visualspeech.face.aam.reference import ReferenceSettings, fit_reference
from visualspeech.jobs import job
from visualspeech.storage import ArrayCollection

with job(snakemake.log[0]), ArrayCollection(snakemake.input.pose) as pose:
    training = of_split(read_utterances(snakemake.input.utterances), "train")
    shapes = (lower_face(pose.array(one.id, "points")) for one in training)
    fit_reference(shapes, ReferenceSettings(**snakemake.params.settings)).save(snakemake.output[0])
