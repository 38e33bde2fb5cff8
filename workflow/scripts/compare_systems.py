"""Table 3: the hidden Markov models against the network that the validation utterances chose."""

from pathlib import Path

from visualspeech.corpora.table import read_split
from visualspeech.evaluation.comparisons import ComparisonSettings
from visualspeech.evaluation.published_results import published
from visualspeech.evaluation.repetitions import pooled
from visualspeech.evaluation.sheets import all_forms
from visualspeech.evaluation.statistics import BootstrapSettings
from visualspeech.evaluation.systems import best_network, system_frame, system_sheets
from visualspeech.evaluation.tables import TableFacts, run_facts
from visualspeech.jobs import job
from visualspeech.provenance import split_hash
from visualspeech.storage import read_table, write_text

with job(snakemake.log[0]):
    rows = pooled({Path(path).parent.name: read_table(path) for path in snakemake.input.metrics})
    network = best_network({Path(path).parent.name: read_table(path) for path in snakemake.input.curves})
    facts = TableFacts(split_hash=split_hash(read_split(snakemake.input.utterances)), **snakemake.params.facts)
    tests = ComparisonSettings(**snakemake.params.comparison, seed=snakemake.params.seed)
    bootstrap = BootstrapSettings(**snakemake.params.bootstrap, seed=snakemake.params.seed)
    paper = published(facts.experiment)
    frame = system_frame(rows, network, paper, tests, bootstrap)
    sheets = system_sheets(frame, network, run_facts(facts, rows[network]), paper, tests)
    for path, text in zip(snakemake.output, all_forms(frame, sheets, "Systems"), strict=True):
        write_text(path, text)
