"""What the listeners of a preference test answered, by the key."""

from visualspeech.corpora.table import read_split
from visualspeech.evaluation.facts import TableFacts
from visualspeech.evaluation.forms import all_forms
from visualspeech.evaluation.measured import MeasuredRows
from visualspeech.evaluation.preference import preference_frame, preference_tables, tally
from visualspeech.evaluation.published_results import published
from visualspeech.jobs import job
from visualspeech.storage.files import write_text
from visualspeech.storage.models import read_shapes
from visualspeech.storage.tables import read_numbers, read_table

source, params = snakemake.input, snakemake.params
with job(snakemake.log[0]):
    key = read_table(source.key, ("utterance", "A", "B"), ["pair"], ["utterance", "A", "B"])
    columns = ("listener", "pair", "answer")
    answers = read_table(source.answers, ("listener", "answer"), required=columns, edited=True)
    found = tally(answers, key, source.answers)
    measured = MeasuredRows.of(params.rows, [read_numbers(path) for path in source.statistics])
    facts = TableFacts.of(params.facts, read_split(source.utterances), read_shapes(source.coding), measured)
    paper = published(params.published)
    frame = preference_frame(found, paper)
    tables = preference_tables(found, facts.lines(measured), paper, measured.titles)
    for path, text in zip(snakemake.output, all_forms(frame, tables, "Preference test"), strict=True):
        write_text(path, text)
