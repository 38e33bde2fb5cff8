"""The table of articulation of a system: closures of the lips and their opening over time."""

from visualspeech.corpora.table import read_split
from visualspeech.evaluation.articulation import read_targets
from visualspeech.evaluation.articulation_table import articulation_tables
from visualspeech.evaluation.facts import TableFacts
from visualspeech.evaluation.forms import all_forms
from visualspeech.evaluation.measured import MeasuredRows
from visualspeech.evaluation.statistics import BootstrapSettings
from visualspeech.jobs import job
from visualspeech.storage.files import write_text
from visualspeech.storage.models import read_shapes
from visualspeech.storage.tables import read_numbers

source, params = snakemake.input, snakemake.params
with job(snakemake.log[0]):
    measured = MeasuredRows.of(params.rows, [read_numbers(path) for path in source.statistics])
    facts = TableFacts.of(params.facts, read_split(source.utterances), read_shapes(source.coding), measured)
    bootstrap = BootstrapSettings(**params.bootstrap, seed=params.seed)
    lips = read_targets(source.lips)
    frame, tables = articulation_tables(measured, lips, facts.lines(measured), params.digits, bootstrap)
    for path, text in zip(snakemake.output, all_forms(frame, tables, "Articulation"), strict=True):
        write_text(path, text)
