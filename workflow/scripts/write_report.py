"""The report of a corpus with all its systems: one page that opens offline."""

from visualspeech.corpora.findings import read_findings
from visualspeech.corpora.table import read_split, read_utterances
from visualspeech.evaluation import gathering
from visualspeech.evaluation.report import ReportContent, render_report
from visualspeech.evaluation.study_section import study_section
from visualspeech.jobs import job
from visualspeech.provenance import split_hash
from visualspeech.storage.files import write_text

source, params, page = snakemake.input, snakemake.params, snakemake.output[0]
with job(snakemake.log[0]):
    utterances = read_utterances(source.utterances)
    content = ReportContent(
        corpus=params.corpus,
        split_hash=split_hash(read_split(source.utterances)),
        systems=tuple(gathering.system_section(given, source.alignment, page) for given in params.systems),
        tables=gathering.fragments(source.get("tables", [])),
        studies=tuple(study_section(folder, page) for folder in source.get("evaluations", [])),
        consent=params.consent,
        utterances=gathering.split_sizes(utterances),
        findings=tuple(read_findings(source.findings, *dict.fromkeys(given["findings"] for given in params.systems))),
        timings=gathering.stage_timings(source.benchmarks, source.faces),
        settings=params.settings,
        versions=gathering.versions(),
        **gathering.origin(),
    )
    write_text(page, render_report(content))
