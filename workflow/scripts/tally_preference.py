"""Fig. 4: what the listeners of a preference test answered, by the key."""

from visualspeech.evaluation.preference import preference_frame, preference_sheets, tally
from visualspeech.evaluation.published_results import published
from visualspeech.evaluation.sheets import all_forms
from visualspeech.jobs import job
from visualspeech.storage import read_table, write_text

with job(snakemake.log[0]):
    key = read_table(snakemake.input.key, ("utterance", "A", "B"))
    found = tally(read_table(snakemake.input.answers, ("listener", "answer")), key)
    paper = published(snakemake.params.experiment)
    shares, source = (paper.preference, paper.source) if paper else ({}, "")
    frame, sheets = preference_frame(found, shares), preference_sheets(found, shares, source)
    for path, text in zip(snakemake.output, all_forms(frame, sheets, "Preference"), strict=True):
        write_text(path, text)
