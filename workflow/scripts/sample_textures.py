"""Read the lower face out of every frame of one shard, inside the mean shape, and the reference face of each clip."""

from visualspeech.corpora.table import read_utterances
from visualspeech.face.aam.points import lower_face, to_vector
from visualspeech.face.aam.reference import Reference, sample_textures
from visualspeech.face.drift import DriftSettings, reference_of
from visualspeech.jobs import job, progress
from visualspeech.media.reading import read_frames
from visualspeech.speech.alignment import read_alignments, silent_frames
from visualspeech.storage import ArrayReader, ArrayWriter

UNITS = {"shape": "px of the frontal picture", "texture": "grey levels"}

with (
    job(snakemake.log[0]),
    ArrayReader(snakemake.input.landmarks) as landmarks,
    ArrayReader(snakemake.input.pose) as pose,
    ArrayWriter(snakemake.output[0]) as out,
):
    reference = Reference.load(snakemake.input.reference)
    settings = DriftSettings(**snakemake.params.drift)
    alignments = read_alignments(snakemake.input.alignment)
    utterances = [one for one in read_utterances(snakemake.input.utterances) if one.id in pose]
    for one in progress(utterances, len(utterances), "utterances"):
        points, rate = lower_face(landmarks.array(one.id, "points")), pose.rate(one.id)
        texture = sample_textures(read_frames(one.media, one.start, one.end), points, reference)
        shape = to_vector(lower_face(pose.array(one.id, "points")))
        silent = silent_frames(alignments[one.id], len(shape), rate)
        face = reference_of(shape, texture, silent, settings, rate=rate)
        arrays = {"shape": shape, "texture": texture, "reference_shape": face.shape, "reference_texture": face.texture}
        out.add(one.id, arrays, rate, UNITS)
