"""Measure one model's predictions of the test and validation utterances against the recorded faces.

Those of the test utterances are measured on the frames of the camera too, on which systems of different rates compare.
"""

from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.evaluation.articulation import read_targets
from visualspeech.evaluation.own_functions import with_own
from visualspeech.evaluation.scoring import score_table
from visualspeech.evaluation.sequences import OnFrames, scores
from visualspeech.face.aam.model import Aam
from visualspeech.jobs import job
from visualspeech.speech.alignment import alignments_of
from visualspeech.storage.arrays import ArrayCollection, ArrayReader
from visualspeech.storage.tables import write_table

source, own = snakemake.input, snakemake.params.own
with (
    job(snakemake.log[0]),
    ArrayReader(source.predictions) as predictions,
    ArrayCollection(source.targets) as targets,
    ArrayCollection(source.parameters) as recorded,
):
    aam, utterances = Aam.load(source.coding), read_utterances(source.utterances)
    lips, drift_kept = read_targets(source.lips), snakemake.params.drift == "none"
    speakers = {one.id: one.speaker for one in utterances}
    for split in ("test", "validation"):
        aligned = alignments_of(source.alignment, [one.id for one in of_split(utterances, split)])
        rows = scores(aligned, predictions, targets, aam, lips, drift_kept)
        rows = with_own(rows, own, predictions, targets, aam, speakers)
        write_table(snakemake.output[split], score_table(rows))
    aligned = alignments_of(source.alignment, [one.id for one in of_split(utterances, "test")])
    rows = scores(aligned, OnFrames(predictions, recorded), recorded, aam, lips, drift_kept)
    write_table(snakemake.output.camera, score_table(rows))
