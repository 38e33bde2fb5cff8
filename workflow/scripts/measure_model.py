"""Measure one model's predictions of the test and validation utterances against the recorded faces."""

from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.evaluation.scoring import score_table
from visualspeech.evaluation.sequences import scores
from visualspeech.face.aam.model import Aam
from visualspeech.jobs import job
from visualspeech.storage.arrays import ArrayCollection, ArrayReader
from visualspeech.storage.tables import write_table

source = snakemake.input
with (
    job(snakemake.log[0]),
    ArrayReader(source.predictions) as predictions,
    ArrayCollection(source.targets) as targets,
):
    aam, utterances = Aam.load(source.coding), read_utterances(source.utterances)
    for split in ("test", "validation"):
        ids = [one.id for one in of_split(utterances, split)]
        rows = scores(ids, predictions, targets, aam, drift_kept=snakemake.params.drift == "none")
        write_table(snakemake.output[split], score_table(rows))
