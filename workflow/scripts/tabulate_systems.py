"""All systems of a corpus side by side."""

from visualspeech.corpora.table import read_split
from visualspeech.evaluation.across_systems import SystemRows, systems_frame, systems_tables
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
    split, systems = read_split(source.utterances), []
    for given in params.systems:
        measured = MeasuredRows.of(given["rows"], [read_numbers(path) for path in given["statistics"]])
        facts = TableFacts.of(given["facts"], split, read_shapes(given["coding"]), measured)
        systems.append(SystemRows(given["title"], facts, measured))
    bootstrap = BootstrapSettings(**params.bootstrap, seed=params.seed)
    frame = systems_frame(systems, bootstrap)
    tables = systems_tables(frame, systems, bootstrap, params.digits)
    for path, text in zip(snakemake.output, all_forms(frame, tables, "Systems"), strict=True):
        write_text(path, text)
