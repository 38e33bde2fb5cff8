"""Align the speech of one shard with its transcripts."""

from visualspeech.corpora.findings import rejection, write_findings
from visualspeech.corpora.table import read_utterances
from visualspeech.errors import RejectedUtterance
from visualspeech.jobs import job, progress
from visualspeech.speech.alignment import to_table
from visualspeech.speech.forced_alignment import Aligner, AlignmentSettings
from visualspeech.storage.arrays import ArrayReader
from visualspeech.storage.tables import write_table

with job(snakemake.log[0]), ArrayReader(snakemake.input.audio) as audio:
    aligner = Aligner(AlignmentSettings(**snakemake.params.settings))
    utterances = [one for one in read_utterances(snakemake.input.utterances) if one.id in audio]
    alignments, findings = {}, []
    for utterance in progress(utterances, len(utterances), "utterances"):
        try:
            alignments[utterance.id] = aligner.align(audio.array(utterance.id, "samples"), utterance.transcript)
        except RejectedUtterance as error:
            findings.append(rejection(utterance.id, "alignment", utterance.media, error))
    write_table(snakemake.output.table, to_table(alignments))
    write_findings(snakemake.output.findings, findings)
