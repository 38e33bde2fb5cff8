"""Measure one model's predictions of the test utterances against the recorded faces."""

from visualspeech.evaluation.metrics import score, score_table
from visualspeech.evaluation.sequences import predicted_sequence, recorded_sequence
from visualspeech.face.aam.model import Aam
from visualspeech.jobs import job
from visualspeech.storage import ArrayCollection, ArrayReader, write_table

with (
    job(snakemake.log[0]),
    ArrayReader(snakemake.input.predictions) as predictions,
    ArrayCollection(snakemake.input.features) as features,
):
    aam = Aam.load(snakemake.input.aam)
    rows = [
        score(
            one,
            predicted_sequence(predictions.array(one, "appearance"), aam),
            recorded_sequence(features[one], aam.points),
        )
        for one in predictions.ids
    ]
    write_table(snakemake.output[0], score_table(rows))
