"""Measure one model's predictions of the test and validation utterances by region of the face.

Those of the test utterances are measured on the frames of the recordings too, on which systems of different rates
compare.
"""

from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.evaluation.regions import region_scores
from visualspeech.evaluation.scoring import score_table
from visualspeech.evaluation.sequences import OnFrames
from visualspeech.face.marker_coding import MarkerCoding
from visualspeech.jobs import job
from visualspeech.storage.arrays import ArrayCollection, ArrayReader
from visualspeech.storage.tables import write_table

source = snakemake.input
with (
    job(snakemake.log[0]),
    ArrayReader(source.predictions) as predictions,
    ArrayCollection(source.targets) as targets,
    ArrayCollection(source.parameters) as recorded,
):
    regions, utterances = MarkerCoding.load(source.coding).regions, read_utterances(source.utterances)
    test, validation = ([one.id for one in of_split(utterances, split)] for split in ("test", "validation"))
    write_table(snakemake.output.test, score_table(region_scores(test, predictions, targets, regions)))
    write_table(snakemake.output.validation, score_table(region_scores(validation, predictions, targets, regions)))
    on_frames = region_scores(test, OnFrames(predictions, recorded), recorded, regions)
    write_table(snakemake.output.camera, score_table(on_frames))
