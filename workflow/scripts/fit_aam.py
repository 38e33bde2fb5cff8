"""Train the active appearance model on frames of the training utterances."""

from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.face.aam.model import AamSettings
from visualspeech.face.aam.training import fit_aam
from visualspeech.face.point_sets import read_point_set
from visualspeech.jobs import job
from visualspeech.storage.arrays import ArrayCollection

with job(snakemake.log[0]), ArrayCollection(snakemake.input.textures) as textures:
    utterances = [one for one in read_utterances(snakemake.input.utterances) if one.id in textures]
    training = [one.id for one in of_split(utterances, "train")]
    points = read_point_set(snakemake.params.points)
    settings = AamSettings(**snakemake.params.settings, seed=snakemake.params.seed)
    fit_aam(textures, training, points, settings, snakemake.resources.tmpdir).save(snakemake.output[0])
