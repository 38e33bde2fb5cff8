"""Read the lower face's texture out of every frame of one shard, inside the mean shape."""

from visualspeech.corpora.table import read_utterances
from visualspeech.face.aam.points import lower_face, to_vector
from visualspeech.face.aam.reference import Reference, sample_textures
from visualspeech.jobs import job, progress
from visualspeech.media import read_frames
from visualspeech.storage import ArrayReader, ArrayWriter

UNITS = {"shape": "px of the frontal picture", "texture": "grey levels"}

with (
    job(snakemake.log[0]),
    ArrayReader(snakemake.input.landmarks) as landmarks,
    ArrayReader(snakemake.input.pose) as pose,
    ArrayWriter(snakemake.output[0]) as out,
):
    reference = Reference.load(snakemake.input.reference)
    utterances = [one for one in read_utterances(snakemake.input.utterances) if one.id in pose]
    for one in progress(utterances, len(utterances), "utterances"):
        frames = read_frames(one.media, one.start, one.end)
        textures = sample_textures(frames, lower_face(landmarks.array(one.id, "points")), reference)
        shapes = to_vector(lower_face(pose.array(one.id, "points")))
        out.add(one.id, {"shape": shapes, "texture": textures}, pose.rate(one.id), UNITS)
