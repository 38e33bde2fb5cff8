"""Follow the 68 landmarks through the recordings of one shard."""

from visualspeech.corpora.findings import WARN, Finding, rejection, write_findings
from visualspeech.corpora.table import read_utterances
from visualspeech.errors import RejectedUtterance
from visualspeech.face.landmarks import LandmarkSettings, track
from visualspeech.jobs import job, progress
from visualspeech.media import probe, read_frames
from visualspeech.storage import ArrayReader, ArrayWriter

with job(snakemake.log[0]):
    settings = LandmarkSettings(**snakemake.params.settings)
    with ArrayReader(snakemake.input.audio) as audio:
        utterances = [one for one in read_utterances(snakemake.input.utterances) if one.id in audio]
    findings = []
    with ArrayWriter(snakemake.output.landmarks) as out:
        for utterance in progress(utterances, len(utterances), "utterances"):
            try:
                rate = probe(utterance.media).rate
                tracked = track(read_frames(utterance.media, utterance.start, utterance.end), settings, rate)
            except RejectedUtterance as error:
                findings.append(rejection(utterance.id, "landmarks", utterance.media, error))
                continue
            arrays = {"points": tracked.points, "detected": tracked.detected}
            size = {"width": tracked.width, "height": tracked.height}
            out.add(utterance.id, arrays, rate, units={"points": "px of the recorded picture"}, **size)
            findings += [Finding(utterance.id, "landmarks", WARN, utterance.media, text) for text in tracked.findings]
    write_findings(snakemake.output.findings, findings)
