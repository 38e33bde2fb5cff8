"""Decide which utterances the models of a visual coding see: the accepted ones whose faces were read."""

from visualspeech.corpora.findings import check_share, check_splits, read_findings, rejected_ids, write_findings
from visualspeech.corpora.table import read_split, read_utterances, write_accepted
from visualspeech.jobs import job, log

with job(snakemake.log[0]):
    utterances, split = read_utterances(snakemake.input.utterances), read_split(snakemake.input.split)
    findings, earlier = read_findings(*snakemake.input.findings), read_findings(snakemake.input.earlier)
    check_share([*findings, *earlier], len(split), snakemake.params.limit)
    accepted = [one for one in utterances if one.id not in rejected_ids(findings)]
    check_splits(accepted)
    log.info("the faces of %d of %d utterances were read", len(accepted), len(utterances))
    write_accepted(snakemake.output.accepted, accepted, split)
    write_findings(snakemake.output.findings, findings)
