"""Estimate the head's pose in every frame of one shard and bring its landmarks to the frontal view."""

from visualspeech.face.pose import HeadModel, PoseSettings, estimate, to_frontal
from visualspeech.jobs import job, progress
from visualspeech.storage import ArrayReader, ArrayWriter

UNITS = {"rotation": "rad", "translation": "model units", "points": "px of the frontal picture"}

with (
    job(snakemake.log[0]),
    ArrayReader(snakemake.input.landmarks) as landmarks,
    ArrayWriter(snakemake.output[0]) as out,
):
    head = HeadModel.load(snakemake.input.head)
    settings = PoseSettings(**snakemake.params.settings)
    for one in progress(landmarks.ids, len(landmarks.ids), "utterances"):
        points = landmarks.array(one, "points")
        pose = estimate(points, head, settings, rate=landmarks.rate(one))
        arrays = {"rotation": pose.rotation, "translation": pose.translation, "points": to_frontal(points, pose, head)}
        out.add(one, arrays, landmarks.rate(one), UNITS)
