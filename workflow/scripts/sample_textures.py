"""Sample shapes and textures of the faces in every frame of one shard, and the reference face of each utterance."""

from visualspeech.corpora.findings import attempt, write_findings
from visualspeech.corpora.table import read_utterances
from visualspeech.face.aam.reference import Reference, sample_faces
from visualspeech.face.drift import DriftSettings
from visualspeech.jobs import job, progress
from visualspeech.media.reading import read_frames
from visualspeech.speech.alignment import read_alignments, silent_frames
from visualspeech.storage.arrays import ArrayReader, ArrayWriter

UNITS = {"shape": "px of the normalised face", "texture": "grey levels"}

with (
    job(snakemake.log[0]),
    ArrayReader(snakemake.input.landmarks) as landmarks,
    ArrayReader(snakemake.input.pose) as pose,
    ArrayWriter(snakemake.output.textures) as out,
):
    reference = Reference.load(snakemake.input.reference)
    drift, alignments = DriftSettings(**snakemake.params.drift), read_alignments(snakemake.input.alignment)
    utterances, findings = [one for one in read_utterances(snakemake.input.utterances) if one.id in pose], []
    for one in progress(utterances, len(utterances), "utterances"):
        frames, rate = read_frames(one.media, one.start, one.end), pose.rate(one.id)
        points = landmarks.array(one.id, "points"), pose.array(one.id, "points")
        silent = silent_frames(alignments[one.id], len(points[1]), rate)
        faces = attempt(one, "textures", sample_faces, frames, *points, reference, silent, drift, rate=rate)
        findings += faces.findings
        if faces.rejected is None:
            out.add(one.id, faces.value.arrays(), rate, UNITS)
    write_findings(snakemake.output.findings, findings)
