"""Align the speech of one shard with its transcripts; without any, tell speech from pauses."""

from visualspeech.corpora.findings import attempt, write_findings
from visualspeech.corpora.table import read_utterances
from visualspeech.jobs import job, progress
from visualspeech.speech.alignment import to_table
from visualspeech.speech.forced_alignment import Aligner, AlignmentSettings
from visualspeech.speech.segmentation import segmented
from visualspeech.storage.arrays import ArrayReader
from visualspeech.storage.tables import write_table

with job(snakemake.log[0]), ArrayReader(snakemake.input.audio) as audio:
    settings = AlignmentSettings(**snakemake.params.settings)
    align = Aligner(settings).align if snakemake.params.text else segmented
    utterances = [one for one in read_utterances(snakemake.input.utterances) if one.id in audio]
    alignments, findings = {}, []
    for one in progress(utterances, len(utterances), "utterances"):
        aligned = attempt(one, "alignment", align, audio.array(one.id, "samples"), one.transcript)
        findings += aligned.findings
        if aligned.rejected is None:
            alignments[one.id] = aligned.value
    write_table(snakemake.output.table, to_table(alignments))
    write_findings(snakemake.output.findings, findings)
