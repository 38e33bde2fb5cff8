"""Fit the appearance model to every frame of one shard; where it diverges the tracker's points are kept and flagged."""

from visualspeech.corpora.table import read_utterances
from visualspeech.face.aam.fitting import FittingModel, FittingSettings
from visualspeech.face.aam.fitting.faces import fit_faces
from visualspeech.face.aam.model import Aam, reference_face
from visualspeech.face.aam.reference import Reference
from visualspeech.face.drift import DriftSettings, reference_of
from visualspeech.face.pose import HeadModel, Pose
from visualspeech.jobs import job, log, progress
from visualspeech.media.reading import read_frames
from visualspeech.speech.alignment import read_alignments, silent_frames
from visualspeech.storage import ArrayReader, ArrayWriter

UNITS = {"points": "px of the recorded picture", "shape": "px of the frontal picture", "error": "grey levels"}

source, settings = snakemake.input, snakemake.params
with (
    job(snakemake.log[0]),
    ArrayReader(source.landmarks) as landmarks,
    ArrayReader(source.pose) as pose,
    ArrayReader(source.textures) as tracked,
    ArrayWriter(snakemake.output[0]) as out,
):
    aam, reference, head = Aam.load(source.aam), Reference.load(source.reference), HeadModel.load(source.head)
    model = FittingModel.of_aam(aam, reference, FittingSettings(**settings.fitting))
    drift, alignments = DriftSettings(**settings.drift), read_alignments(source.alignment)
    utterances = [one for one in read_utterances(source.utterances) if one.id in tracked]
    for one in progress(utterances, len(utterances), "utterances"):
        turned = Pose(pose.array(one.id, "rotation"), pose.array(one.id, "translation"))
        light = reference_face(tracked, one.id), aam.drift
        frames, points = read_frames(one.media, one.start, one.end), landmarks.array(one.id, "points")
        found = fit_faces(frames, points, turned, head, model, reference, light)
        if found.diverged.any():
            log.info("%s: %d of %d frames diverged", one.id, found.diverged.sum(), len(found.diverged))
        silent = silent_frames(alignments[one.id], len(found.shape), pose.rate(one.id))
        face = reference_of(found.shape, found.texture, silent, drift, rate=pose.rate(one.id))
        arrays = {**vars(found), "reference_shape": face.shape, "reference_texture": face.texture}
        out.add(one.id, arrays, pose.rate(one.id), UNITS)
