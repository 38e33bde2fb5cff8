"""Measure one model's predictions of the test utterances against the recorded faces."""

from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.evaluation.metrics import score, score_table
from visualspeech.evaluation.sequences import predicted_sequence, recorded_sequence
from visualspeech.face.aam.model import Aam
from visualspeech.jobs import job
from visualspeech.storage.arrays import ArrayCollection, ArrayReader
from visualspeech.storage.tables import write_table

with (
    job(snakemake.log[0]),
    ArrayReader(snakemake.input.predictions) as predictions,
    ArrayCollection(snakemake.input.targets) as targets,
):
    aam = Aam.load(snakemake.input.coding)
    rows = [
        score(
            one.id,
            predicted_sequence(predictions.array(one.id, "appearance"), aam),
            recorded_sequence(targets[one.id], aam.points),
            targets.rate(one.id),
        )
        for one in of_split(read_utterances(snakemake.input.utterances), "test")
    ]
    write_table(snakemake.output[0], score_table(rows))
