"""Estimate the head pose in every frame of one shard and bring its landmarks to the normalised face."""

from visualspeech.corpora.records import legal_id
from visualspeech.corpora.table import read_utterances
from visualspeech.face.head import PoseSettings, load_heads
from visualspeech.face.pose import estimate, to_frontal
from visualspeech.jobs import job, progress
from visualspeech.storage.arrays import ArrayReader, ArrayWriter

UNITS = {"rotation": "rad", "translation": "units of the head", "points": "px of the normalised face"}

with (
    job(snakemake.log[0]),
    ArrayReader(snakemake.input.landmarks) as landmarks,
    ArrayWriter(snakemake.output[0]) as out,
):
    heads = load_heads(snakemake.params.speakers, snakemake.input.heads)
    speakers = {one.id: legal_id(one.speaker) for one in read_utterances(snakemake.input.utterances)}
    settings = PoseSettings(**snakemake.params.settings)
    for one in progress(landmarks.ids, len(landmarks.ids), "utterances"):
        points, head = landmarks.array(one, "points"), heads[speakers[one]]
        pose = estimate(points, head, settings, rate=landmarks.rate(one))
        arrays = {"rotation": pose.rotation, "translation": pose.translation, "points": to_frontal(points, pose, head)}
        out.add(one, arrays, landmarks.rate(one), UNITS)
