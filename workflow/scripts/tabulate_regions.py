"""Models by region of the face, with their size and the cost of their training, beside published figures."""

from visualspeech.corpora.table import read_split
from visualspeech.evaluation.facts import TableFacts
from visualspeech.evaluation.forms import all_forms
from visualspeech.evaluation.measured import MeasuredRows
from visualspeech.evaluation.published_results import published
from visualspeech.evaluation.region_table import cost_of, region_frame, region_tables
from visualspeech.evaluation.statistics import BootstrapSettings
from visualspeech.jobs import job
from visualspeech.storage.files import write_text
from visualspeech.storage.models import read_model, read_shapes
from visualspeech.storage.tables import read_numbers, read_table

source, params = snakemake.input, snakemake.params
with job(snakemake.log[0]):
    measured = MeasuredRows.of(params.rows, [read_numbers(path) for path in source.statistics])
    facts = TableFacts.of(params.facts, read_split(source.utterances), read_shapes(source.coding), measured)
    costs = {
        name: cost_of(read_model(model)[0], read_table(curve))
        for name, model, curve in zip(params.trained, source.models, source.curves, strict=True)
    }
    paper, bootstrap = published(params.published), BootstrapSettings(**params.bootstrap, seed=params.seed)
    frame = region_frame(measured, costs, bootstrap, paper)
    tables = region_tables(frame, measured, facts.lines(measured), bootstrap, paper, params.digits, params.needs)
    for path, text in zip(snakemake.output, all_forms(frame, tables, "Regions of the face"), strict=True):
        write_text(path, text)
