"""The result table of the run, in four forms from one definition."""

from pathlib import Path

from visualspeech.corpora.table import read_split
from visualspeech.evaluation.statistics import BootstrapSettings
from visualspeech.evaluation.table_formats import to_html_page, to_latex, to_markdown, to_tsv
from visualspeech.evaluation.tables import TableFacts, result_table
from visualspeech.jobs import job
from visualspeech.provenance import split_hash
from visualspeech.storage import read_table, write_text

with job(snakemake.log[0]):
    measured = {Path(path).parent.name: read_table(path) for path in snakemake.input.metrics}
    facts = TableFacts(split_hash=split_hash(read_split(snakemake.input.utterances)), **snakemake.params.facts)
    settings = {
        key: value for key, value in snakemake.params.settings.items() if key not in ("bootstrap", "comparison")
    }
    bootstrap = BootstrapSettings(**snakemake.params.settings["bootstrap"], seed=snakemake.params.seed)
    table = result_table(measured, facts, settings, bootstrap)
    for path, form in zip(snakemake.output, (to_tsv, to_markdown, to_latex, to_html_page), strict=True):
        write_text(path, form(table))
