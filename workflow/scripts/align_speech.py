"""Align the speech of one shard: with its transcripts, or from files; without either, tell speech from pauses."""

from visualspeech.corpora.aligning import AlignmentSources, aligner
from visualspeech.corpora.findings import WARN, Finding, attempt, write_findings
from visualspeech.corpora.table import read_utterances
from visualspeech.jobs import job, progress
from visualspeech.speech.alignment import to_table
from visualspeech.speech.alignment_settings import AlignmentSettings
from visualspeech.storage.arrays import ArrayReader
from visualspeech.storage.tables import write_table

params, stage = snakemake.params, "alignment"
with job(snakemake.log[0]), ArrayReader(snakemake.input.audio) as audio:
    align = aligner(AlignmentSettings(**params.settings), AlignmentSources.of(params.sources), params.text)
    utterances = [one for one in read_utterances(snakemake.input.utterances) if one.id in audio]
    alignments, findings = {}, []
    for one in progress(utterances, len(utterances), "utterances"):
        aligned = attempt(one, stage, align, one, audio.array(one.id, "samples"))
        findings += aligned.findings
        if aligned.rejected is None:
            alignments[one.id] = aligned.value.alignment
            findings += [Finding(one.id, stage, WARN, one.file, *warning) for warning in aligned.value.warnings]
    write_table(snakemake.output.table, to_table(alignments))
    write_findings(snakemake.output.findings, findings)
