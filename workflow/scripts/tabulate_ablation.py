"""Models with and without something, and the differences of their figures."""

from visualspeech.corpora.table import read_split
from visualspeech.evaluation.ablation import ablation_frame, ablation_tables
from visualspeech.evaluation.facts import TableFacts
from visualspeech.evaluation.forms import all_forms
from visualspeech.evaluation.measured import MeasuredRows
from visualspeech.evaluation.metrics import CENTRED
from visualspeech.evaluation.own_metrics import register
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
    facts = TableFacts.of(params.facts, read_split(source.utterances), read_shapes(source.coding), measured)
    settings, bootstrap = TableSettings(**params.settings), BootstrapSettings(**params.bootstrap, seed=params.seed)
    metrics = [metric.name for metric in measured.metrics(settings.metrics, CENTRED)]
    frame = ablation_frame(measured, params.ablation["columns"], params.ablation["rows"], metrics, bootstrap)
    tables = ablation_tables(frame, measured, facts.lines(measured, CENTRED), bootstrap, settings.digits)
    for path, text in zip(snakemake.output, all_forms(frame, tables, "Ablation"), strict=True):
        write_text(path, text)
