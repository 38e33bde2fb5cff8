"""Bring the findings of all shards together, look for duplicates, and refuse a corpus of which too much is unusable."""

from visualspeech.corpora.check import find_duplicates, read_digests
from visualspeech.corpora.findings import check_share, read_findings, write_findings
from visualspeech.corpora.table import read_utterances
from visualspeech.jobs import job, log

with job(snakemake.log[0]):
    utterances = [one for path in snakemake.input.utterances for one in read_utterances(path)]
    findings = read_findings(*snakemake.input.findings)
    findings += find_duplicates(read_digests(snakemake.input.digests), utterances)
    for finding in findings:
        log.info("%s: %s: %s. %s", finding.level, finding.file or finding.id, finding.finding, finding.remedy)
    check_share(findings, len(utterances), snakemake.params.limit)
    write_findings(snakemake.output[0], findings)
