"""Measure one model's predictions of the test and validation utterances by region of the face.

Those of the test utterances are measured on the frames of the recordings too, on which systems of different rates
compare.
"""

from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.evaluation.own_functions import with_own
from visualspeech.evaluation.regions import region_scores
from visualspeech.evaluation.scoring import score_table
from visualspeech.evaluation.sequences import OnFrames
from visualspeech.face.marker_coding import MarkerCoding
from visualspeech.jobs import job
from visualspeech.storage.arrays import ArrayCollection, ArrayReader
from visualspeech.storage.tables import write_table

source, own = snakemake.input, snakemake.params.own
with (
    job(snakemake.log[0]),
    ArrayReader(source.predictions) as predictions,
    ArrayCollection(source.targets) as targets,
    ArrayCollection(source.parameters) as recorded,
):
    coding, utterances = MarkerCoding.load(source.coding), read_utterances(source.utterances)
    regions, speakers = coding.regions, {one.id: one.speaker for one in utterances}
    test, validation = ([one.id for one in of_split(utterances, split)] for split in ("test", "validation"))
    for split, ids in (("test", test), ("validation", validation)):
        rows = region_scores(ids, predictions, targets, regions)
        rows = with_own(rows, own, predictions, targets, coding, speakers)
        write_table(snakemake.output[split], score_table(rows))
    on_frames = region_scores(test, OnFrames(predictions, recorded), recorded, regions)
    write_table(snakemake.output.camera, score_table(on_frames))
