"""The report of a corpus with all its systems: one page that opens offline."""

from visualspeech.corpora.findings import read_findings
from visualspeech.corpora.table import read_split, read_utterances
from visualspeech.evaluation import gathering
from visualspeech.evaluation.own_metrics import register
from visualspeech.evaluation.report import ReportContent, render_report
from visualspeech.evaluation.report_videos import strip
from visualspeech.evaluation.study_section import study_section
from visualspeech.jobs import job
from visualspeech.provenance import split_hash
from visualspeech.storage.files import write_text

source, params, page = snakemake.input, snakemake.params, snakemake.output[0]
with job(snakemake.log[0]):
    for given in params.systems:
        register(given["own"])
    utterances, overviews = read_utterances(source.utterances), gathering.overviews(params.systems)
    systems = tuple(
        gathering.system_section(given, of_system.conclusion.text, source.alignment, page)
        for given, of_system in zip(params.systems, overviews, strict=True)
    )
    content = ReportContent(
        corpus=params.corpus,
        split_hash=split_hash(read_split(source.utterances)),
        systems=systems,
        strip=strip([system.videos for system in systems], page),
        **gathering.overview(overviews, source.across[0]),
        tables=gathering.shown_tables([source.across], page),
        studies=tuple(study_section(folder, page) for folder in source.get("evaluations", [])),
        consent=params.consent,
        utterances=gathering.split_sizes(utterances),
        test=gathering.test_utterances(utterances, source.exports[0], systems, page),
        folders=gathering.folder_links(source.exports, page),
        findings=tuple(read_findings(source.findings, *dict.fromkeys(given["findings"] for given in params.systems))),
        timings=gathering.stage_timings(source.benchmarks, source.faces),
        settings=params.settings,
        versions=gathering.versions(),
        **gathering.origin(),
    )
    write_text(page, render_report(content))
