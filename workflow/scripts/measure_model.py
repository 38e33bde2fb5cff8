"""Measure one model's predictions of the test utterances against the recorded faces."""

from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.evaluation.articulation import articulation_of, read_closures
from visualspeech.evaluation.metrics import score, score_table
from visualspeech.evaluation.sequences import predicted_sequence, recorded_sequence
from visualspeech.face.aam.model import Aam
from visualspeech.jobs import job
from visualspeech.speech.alignment import alignments_of
from visualspeech.storage.arrays import ArrayCollection, ArrayReader
from visualspeech.storage.tables import write_table

with (
    job(snakemake.log[0]),
    ArrayReader(snakemake.input.predictions) as predictions,
    ArrayCollection(snakemake.input.targets) as targets,
):
    aam, closures = Aam.load(snakemake.input.coding), read_closures(snakemake.input.closures)
    names = [one.id for one in of_split(read_utterances(snakemake.input.utterances), "test")]
    aligned, rows = alignments_of(snakemake.input.alignment, names), []
    for name in names:
        appearance, recorded, rate = predictions.array(name, "appearance"), targets[name], targets.rate(name)
        measures = score(name, predicted_sequence(appearance, aam), recorded_sequence(recorded, aam.points), rate)
        rows.append(measures | articulation_of(appearance, recorded["points"], aam, aligned[name], rate, closures))
    write_table(snakemake.output[0], score_table(rows))
