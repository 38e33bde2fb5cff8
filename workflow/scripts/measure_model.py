"""Measure one model's predictions of the test and validation utterances against the recorded faces."""

from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.evaluation.articulation import articulation_of, read_targets
from visualspeech.evaluation.scoring import score_table
from visualspeech.evaluation.sequences import scores
from visualspeech.face.aam.model import Aam
from visualspeech.jobs import job
from visualspeech.speech.alignment import alignments_of
from visualspeech.storage.arrays import ArrayCollection, ArrayReader
from visualspeech.storage.tables import write_table

source = snakemake.input
with (
    job(snakemake.log[0]),
    ArrayReader(source.predictions) as predictions,
    ArrayCollection(source.targets) as targets,
):
    aam, utterances = Aam.load(source.coding), read_utterances(source.utterances)
    lips = read_targets(source.lips)
    for split in ("test", "validation"):
        ids = [one.id for one in of_split(utterances, split)]
        aligned, rows = alignments_of(source.alignment, ids), []
        for row in scores(ids, predictions, targets, aam, drift_kept=snakemake.params.drift == "none"):
            appearance, recorded = predictions.array(row["id"], "appearance"), targets.array(row["id"], "points")
            spoken = aligned[row["id"]], row["rate"], lips
            rows.append(row | articulation_of(appearance, recorded, aam, *spoken))
        write_table(snakemake.output[split], score_table(rows))
