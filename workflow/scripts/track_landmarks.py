"""Follow the 68 landmarks through the recordings of one shard; broken recordings are screened out."""

from visualspeech.corpora.findings import WARN, Finding, rejection, write_findings
from visualspeech.corpora.table import read_utterances
from visualspeech.errors import RejectedUtterance
from visualspeech.face.screening import ScreeningSettings, track_screened
from visualspeech.face.tracker import LandmarkSettings
from visualspeech.jobs import job, progress
from visualspeech.media.reading import probe, read_frames
from visualspeech.storage.arrays import ArrayReader, ArrayWriter

with job(snakemake.log[0]), ArrayWriter(snakemake.output.landmarks) as out:
    settings = LandmarkSettings(**snakemake.params.landmarks), ScreeningSettings(**snakemake.params.screening)
    with ArrayReader(snakemake.input.audio) as audio:
        utterances = [one for one in read_utterances(snakemake.input.utterances) if one.id in audio]
    findings = []
    for one in progress(utterances, len(utterances), "utterances"):
        try:
            rate = probe(one.media).rate
            tracked = track_screened(read_frames(one.media, one.start, one.end), rate, *settings)
        except RejectedUtterance as error:
            findings.append(rejection(one.id, "landmarks", one.media, error))
            continue
        arrays = {"points": tracked.points, "detected": tracked.detected}
        size = {"width": tracked.width, "height": tracked.height}
        out.add(one.id, arrays, rate, {"points": "px of the recorded picture"}, **size)
        findings += [Finding(one.id, "landmarks", WARN, one.media, text) for text in tracked.findings]
    write_findings(snakemake.output.findings, findings)
