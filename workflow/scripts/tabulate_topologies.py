"""The networks by topology and nodes, beside published figures."""

from visualspeech.corpora.table import read_split
from visualspeech.evaluation.facts import TableFacts
from visualspeech.evaluation.forms import all_forms
from visualspeech.evaluation.measured import MeasuredRows
from visualspeech.evaluation.metrics import CENTRED
from visualspeech.evaluation.own_metrics import register
from visualspeech.evaluation.published_results import published, shared_metrics
from visualspeech.evaluation.tables import TableSettings
from visualspeech.evaluation.topologies import topology_frame, topology_tables
from visualspeech.jobs import job
from visualspeech.storage.files import write_text
from visualspeech.storage.models import read_shapes
from visualspeech.storage.tables import read_numbers

source, params = snakemake.input, snakemake.params
with job(snakemake.log[0]):
    register(params.own)
    measured = MeasuredRows.of(params.rows, [read_numbers(path) for path in source.statistics])
    facts = TableFacts.of(params.facts, read_split(source.utterances), read_shapes(source.coding), measured)
    settings, paper = TableSettings(**params.settings), published(params.published)
    frame = topology_frame(measured, shared_metrics(paper, measured.metrics(settings.metrics, CENTRED)), paper)
    digits = settings.digits, settings.ratio_digits
    tables = topology_tables(frame, measured, facts.lines(measured, CENTRED), paper, *digits)
    for path, text in zip(snakemake.output, all_forms(frame, tables, "Topologies"), strict=True):
        write_text(path, text)
