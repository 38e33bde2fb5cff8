"""Fig. 4: what the listeners of a preference test answered, by the key."""

from visualspeech.evaluation.forms import all_forms
from visualspeech.evaluation.preference import preference_frame, preference_tables, tally
from visualspeech.evaluation.published_results import published
from visualspeech.jobs import job
from visualspeech.storage import read_table, write_text

source, params = snakemake.input, snakemake.params
with job(snakemake.log[0]):
    key = read_table(source.key, ("utterance", "A", "B"))
    found = tally(read_table(source.answers, ("listener", "answer")), key, source.answers)
    paper = published(params.published)
    frame = preference_frame(found, paper)
    tables = preference_tables(found, tuple(params.facts.items()), paper, params.titles)
    for path, text in zip(snakemake.output, all_forms(frame, tables, "Preference test"), strict=True):
        write_text(path, text)
