"""The model that the validation utterances chose, beside reference models."""

from visualspeech.corpora.table import read_split
from visualspeech.evaluation.comparisons import ComparisonSettings
from visualspeech.evaluation.facts import TableFacts
from visualspeech.evaluation.forms import all_forms
from visualspeech.evaluation.gains import best_cell, gains_frame, gains_tables, rows_of_gains
from visualspeech.evaluation.measured import MeasuredRows
from visualspeech.evaluation.metrics import CENTRED
from visualspeech.evaluation.own_metrics import register
from visualspeech.evaluation.published_results import published, shared_metrics
from visualspeech.evaluation.statistics import BootstrapSettings
from visualspeech.evaluation.tables import TableSettings
from visualspeech.jobs import job
from visualspeech.storage.files import write_text
from visualspeech.storage.models import read_shapes
from visualspeech.storage.tables import read_numbers

source, params = snakemake.input, snakemake.params
with job(snakemake.log[0]):
    register(params.own)
    measured = MeasuredRows.of(params.rows, [read_numbers(path) for path in source.statistics])
    validation = {one: read_numbers(path) for one, path in zip(params.candidates, source.validation, strict=True)}
    best = best_cell(measured.rows, validation)
    measured = rows_of_gains(measured, best, params.references)
    facts = TableFacts.of(params.facts, read_split(source.utterances), read_shapes(source.coding), measured)
    settings, paper = TableSettings(**params.settings), published(params.published)
    tests = ComparisonSettings(**params.comparison, seed=params.seed)
    bootstrap = BootstrapSettings(**params.bootstrap, seed=params.seed)
    frame = gains_frame(
        measured, best, shared_metrics(paper, measured.metrics(settings.metrics, CENTRED)), paper, tests, bootstrap
    )
    tables = gains_tables(frame, measured, best, facts.lines(measured, CENTRED), paper, tests, settings.digits)
    for path, text in zip(snakemake.output, all_forms(frame, tables, "Best network"), strict=True):
        write_text(path, text)
