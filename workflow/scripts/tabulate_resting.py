"""The face at rest that a talking head shows in pauses, beside what the models predict there."""

from visualspeech.corpora.table import of_split, read_split, read_utterances
from visualspeech.evaluation.facts import TableFacts
from visualspeech.evaluation.forms import all_forms
from visualspeech.evaluation.measured import MeasuredRows
from visualspeech.evaluation.metrics import CENTRED
from visualspeech.evaluation.resting import resting_frame, resting_rows, resting_tables, training_rest
from visualspeech.evaluation.scoring import score_table
from visualspeech.evaluation.statistics import BootstrapSettings
from visualspeech.jobs import job
from visualspeech.speech.alignment import alignments_of
from visualspeech.storage.arrays import ArrayCollection, ArrayReader
from visualspeech.storage.files import write_text
from visualspeech.storage.models import read_shapes

source, params = snakemake.input, snakemake.params
with job(snakemake.log[0]), ArrayCollection(source.targets) as targets:
    utterances, tables = read_utterances(source.utterances), []
    training, test = (
        alignments_of(source.alignment, [one.id for one in of_split(utterances, split)]) for split in ("train", "test")
    )
    rest = training_rest(training.items, targets)
    for path in source.predictions:
        with ArrayReader(path) as predictions:
            tables.append(score_table(resting_rows(test.items(), predictions, targets, rest)))
    measured = MeasuredRows.of(params.rows, tables)
    facts = TableFacts.of(params.facts, read_split(source.utterances), read_shapes(source.coding), measured)
    bootstrap = BootstrapSettings(**params.bootstrap, seed=params.seed)
    frame = resting_frame(measured, bootstrap)
    sheets = resting_tables(frame, measured, facts.lines(measured, CENTRED), bootstrap, params.digits)
    for path, text in zip(snakemake.output, all_forms(frame, sheets, "Face at rest"), strict=True):
        write_text(path, text)
