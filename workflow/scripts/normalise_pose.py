"""Estimate the head pose in every frame of one shard and bring its landmarks to the normalised face."""

from visualspeech.corpora.findings import attempt, write_findings
from visualspeech.corpora.records import legal_id
from visualspeech.corpora.table import read_utterances
from visualspeech.face.head import PoseSettings, load_heads
from visualspeech.face.pose import normalise
from visualspeech.jobs import job, progress
from visualspeech.storage.arrays import ArrayReader, ArrayWriter

UNITS = {"rotation": "rad", "translation": "units of the head", "points": "px of the normalised face"}

with (
    job(snakemake.log[0]),
    ArrayReader(snakemake.input.landmarks) as landmarks,
    ArrayWriter(snakemake.output.pose) as out,
):
    heads = load_heads(snakemake.params.speakers, snakemake.input.heads)
    utterances = {one.id: one for one in read_utterances(snakemake.input.utterances)}
    settings, findings = PoseSettings(**snakemake.params.settings), []
    for one in progress(landmarks.ids, len(landmarks.ids), "utterances"):
        points, rate = landmarks.array(one, "points"), landmarks.rate(one)
        head = heads[legal_id(utterances[one].speaker)]
        found = attempt(utterances[one], "pose", normalise, points, head, settings, rate=rate)
        findings += found.findings
        if found.rejected is None:
            pose, frontal = found.value
            arrays = {"rotation": pose.rotation, "translation": pose.translation, "points": frontal}
            out.add(one, arrays, rate, UNITS)
    write_findings(snakemake.output.findings, findings)
