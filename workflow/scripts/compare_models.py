"""Paired tests over utterances of all pairs of rows; seeds of one network count as one row."""

from pathlib import Path

from visualspeech.corpora.table import read_split
from visualspeech.evaluation.comparisons import ComparisonSettings, compare, comparison_sheets
from visualspeech.evaluation.repetitions import pooled
from visualspeech.evaluation.sheets import all_forms
from visualspeech.evaluation.statistics import BASE_ROW, BootstrapSettings
from visualspeech.evaluation.tables import TableFacts, run_facts
from visualspeech.jobs import job
from visualspeech.provenance import split_hash
from visualspeech.storage import read_table, write_text

with job(snakemake.log[0]):
    rows = pooled({Path(path).parent.name: read_table(path) for path in snakemake.input.metrics})
    facts = TableFacts(split_hash=split_hash(read_split(snakemake.input.utterances)), **snakemake.params.facts)
    tests = ComparisonSettings(**snakemake.params.comparison, seed=snakemake.params.seed)
    bootstrap = BootstrapSettings(**snakemake.params.bootstrap, seed=snakemake.params.seed)
    frame = compare(rows, snakemake.params.metrics, tests, bootstrap)
    sheets = comparison_sheets(frame, len(rows[BASE_ROW]), tests, run_facts(facts, rows[BASE_ROW]))
    for path, text in zip(snakemake.output, all_forms(frame, sheets, "Paired comparisons"), strict=True):
        write_text(path, text)
