"""Chosen rows and measures of a system, beside published figures."""

from visualspeech.corpora.table import read_split
from visualspeech.evaluation.facts import TableFacts
from visualspeech.evaluation.forms import all_forms
from visualspeech.evaluation.latex import LatexSettings
from visualspeech.evaluation.measured import MeasuredRows
from visualspeech.evaluation.own_metrics import register
from visualspeech.evaluation.published_results import published
from visualspeech.evaluation.selection_settings import SelectionSettings
from visualspeech.evaluation.selections import selection_frame, selection_tables
from visualspeech.evaluation.statistics import BootstrapSettings
from visualspeech.jobs import job
from visualspeech.storage.files import write_text
from visualspeech.storage.models import read_shapes
from visualspeech.storage.tables import read_numbers

source, params = snakemake.input, snakemake.params
with job(snakemake.log[0]):
    register(params.own)
    measured = MeasuredRows.of(params.rows, [read_numbers(path) for path in source.statistics])
    facts = TableFacts.of(params.facts, read_split(source.utterances), read_shapes(source.coding), measured)
    settings, paper = SelectionSettings(**params.settings), published(params.published)
    bootstrap, lines = BootstrapSettings(**params.bootstrap, seed=params.seed), facts.lines(measured)
    printed = paper.selections.get(params.selection) if paper else None
    frame = selection_frame(measured, settings, bootstrap, printed)
    tables = selection_tables(frame, measured, settings, params.selection, lines, bootstrap, paper, params.digits)
    forms = all_forms(frame, tables, settings.title or params.selection, LatexSettings(**params.latex))
    for path, text in zip(snakemake.output, forms, strict=True):
        write_text(path, text)
