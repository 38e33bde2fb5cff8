"""Table 1: the networks by topology and nodes, beside the figures that the paper prints."""

from pathlib import Path

from visualspeech.corpora.table import read_split
from visualspeech.evaluation.published_results import published
from visualspeech.evaluation.sheets import all_forms
from visualspeech.evaluation.statistics import BASE_ROW
from visualspeech.evaluation.tables import TableFacts, TableSettings, run_facts
from visualspeech.evaluation.topologies import topology_frame, topology_sheets
from visualspeech.jobs import job
from visualspeech.provenance import split_hash
from visualspeech.storage import read_table, write_text

with job(snakemake.log[0]):
    measured = {Path(path).parent.name: read_table(path) for path in snakemake.input.metrics}
    facts = TableFacts(split_hash=split_hash(read_split(snakemake.input.utterances)), **snakemake.params.facts)
    lines = (*run_facts(facts, measured[BASE_ROW]), ("nodes of a B layer count", f"one {snakemake.params.b_nodes}"))
    digits = TableSettings(**snakemake.params.settings)
    paper = published(facts.experiment)
    frame = topology_frame(measured, paper)
    sheets = topology_sheets(frame, lines, paper, digits.digits, digits.ratio_digits)
    for path, text in zip(snakemake.output, all_forms(frame, sheets, "Topologies"), strict=True):
        write_text(path, text)
