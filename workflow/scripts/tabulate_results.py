"""The result table of a system: every row with every measure."""

from visualspeech.corpora.table import read_split
from visualspeech.evaluation.facts import TableFacts
from visualspeech.evaluation.forms import all_forms
from visualspeech.evaluation.latex import LatexSettings
from visualspeech.evaluation.measured import MeasuredRows
from visualspeech.evaluation.own_metrics import register
from visualspeech.evaluation.statistics import BootstrapSettings
from visualspeech.evaluation.tables import TableSettings, result_tables
from visualspeech.jobs import job
from visualspeech.storage.files import write_text
from visualspeech.storage.models import read_shapes
from visualspeech.storage.tables import read_numbers

source, params = snakemake.input, snakemake.params
with job(snakemake.log[0]):
    register(params.own)
    measured = MeasuredRows.of(params.rows, [read_numbers(path) for path in source.statistics])
    facts = TableFacts.of(params.facts, read_split(source.utterances), read_shapes(source.coding), measured)
    bootstrap = BootstrapSettings(**params.bootstrap, seed=params.seed)
    frame, tables = result_tables(measured, facts.lines(measured), TableSettings(**params.settings), bootstrap)
    forms = all_forms(frame, tables, "Objective measures", LatexSettings(**params.latex))
    for path, text in zip(snakemake.output, forms, strict=True):
        write_text(path, text)
