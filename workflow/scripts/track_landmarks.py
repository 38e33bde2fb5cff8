"""Follow the 68 landmarks through the recordings of one shard; broken recordings are screened out."""

from visualspeech.corpora.findings import WARN, Finding, attempt, write_findings
from visualspeech.corpora.table import read_utterances
from visualspeech.face.screening import ScreeningSettings, track_recording
from visualspeech.face.tracker import LandmarkSettings
from visualspeech.jobs import job, progress
from visualspeech.storage.arrays import ArrayReader, ArrayWriter

with job(snakemake.log[0]), ArrayWriter(snakemake.output.landmarks) as out:
    settings = LandmarkSettings(**snakemake.params.landmarks), ScreeningSettings(**snakemake.params.screening)
    folder = snakemake.params.folder
    with ArrayReader(snakemake.input.audio) as audio:
        utterances = [one for one in read_utterances(snakemake.input.utterances) if one.id in audio]
    findings = []
    for one in progress(utterances, len(utterances), "utterances"):
        tracked = attempt(one, "landmarks", track_recording, one.media, one.start, one.end, *settings, folder)
        findings += tracked.findings
        if tracked.rejected is None:
            landmarks, rate = tracked.value
            arrays = {"points": landmarks.points, "detected": landmarks.detected}
            size = {"width": landmarks.width, "height": landmarks.height}
            out.add(one.id, arrays, rate, {"points": "px of the recorded picture"}, **size)
            findings += [Finding(one.id, "landmarks", WARN, one.media, text) for text in landmarks.findings]
    write_findings(snakemake.output.findings, findings)
