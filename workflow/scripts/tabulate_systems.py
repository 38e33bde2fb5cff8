"""All systems of a corpus side by side."""

from visualspeech.corpora.table import read_split
from visualspeech.evaluation.across_systems import SystemRows, systems_frame, systems_tables
from visualspeech.evaluation.facts import TableFacts
from visualspeech.evaluation.forms import all_forms
from visualspeech.evaluation.lip_rows import read_lip_tables
from visualspeech.evaluation.measured import MeasuredRows
from visualspeech.evaluation.statistics import BootstrapSettings
from visualspeech.jobs import job
from visualspeech.storage.files import write_text
from visualspeech.storage.models import read_shapes
from visualspeech.storage.tables import read_numbers

source, params = snakemake.input, snakemake.params
with job(snakemake.log[0]):
    lists, systems = list(map(read_split, source.utterances)), []
    # A recording can fail in one visual coding only: systems are compared on what all of them have.
    split = {name: part for name, part in lists[0].items() if all(name in other for other in lists)}
    lost = {name for other in lists for name, part in other.items() if part == "test" and name not in split}
    for given in params.systems:
        measured = MeasuredRows.of(given["rows"], [read_numbers(path) for path in given["statistics"]]).on(split)
        facts = TableFacts.of(given["facts"], split, read_shapes(given["coding"]), measured)
        facts = facts.at(given["rate"])
        names = [row["name"] for row in given["rows"]]
        lips = MeasuredRows.of(given["rows"], read_lip_tables(given["lips"], given["costs"], names)).on(split)
        systems.append(SystemRows(given["title"], facts, measured, lips))
    bootstrap = BootstrapSettings(**params.bootstrap, seed=params.seed)
    frame = systems_frame(systems, bootstrap)
    tables = systems_tables(frame, systems, bootstrap, params.digits, lost)
    for path, text in zip(snakemake.output, all_forms(frame, tables, "Systems"), strict=True):
        write_text(path, text)
