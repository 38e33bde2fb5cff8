"""Check the recordings of one shard before anything heavy runs, and keep their sound for the stages that listen."""

from visualspeech.corpora.check import check_recording, write_digests
from visualspeech.corpora.check_settings import CheckSettings
from visualspeech.corpora.findings import write_findings
from visualspeech.corpora.table import read_utterances
from visualspeech.jobs import job, progress
from visualspeech.speech.dictionary import lexicon_with
from visualspeech.storage.arrays import ArrayWriter

with job(snakemake.log[0]):
    settings = CheckSettings(**snakemake.params.settings)
    lexicon = lexicon_with(**snakemake.params.dictionary)
    utterances = read_utterances(snakemake.input.utterances)
    findings, digests = [], {}
    with ArrayWriter(snakemake.output.audio) as audio:
        for utterance in progress(utterances, len(utterances), "utterances"):
            checked = check_recording(utterance, lexicon.unknown_words, settings, snakemake.params.text)
            findings += checked.findings
            digests[utterance.id] = checked.digest
            if checked.samples is not None:
                audio.add(utterance.id, {"samples": checked.samples}, rate=16000, units={"samples": "16-bit PCM"})
    write_findings(snakemake.output.findings, findings)
    write_digests(snakemake.output.digests, digests)
