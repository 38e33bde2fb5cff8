"""Fit the AAM to every frame of one shard; where it diverges the tracker's points are kept and flagged."""

from visualspeech.corpora.findings import attempt, write_findings
from visualspeech.corpora.records import legal_id
from visualspeech.corpora.table import read_utterances
from visualspeech.face.aam.fitting import FittingModel, FittingSettings
from visualspeech.face.aam.fitting.faces import fit_faces
from visualspeech.face.aam.model import Aam
from visualspeech.face.aam.reference import Reference
from visualspeech.face.drift import DriftSettings, reference_face
from visualspeech.face.head import load_heads
from visualspeech.face.pose import Pose
from visualspeech.jobs import job, log, progress
from visualspeech.media.reading import read_frames
from visualspeech.speech.alignment import read_alignments, silent_frames
from visualspeech.storage.arrays import ArrayReader, ArrayWriter

UNITS = {"points": "px of the recorded frame", "shape": "px of the normalised face", "error": "grey levels"}

source, params = snakemake.input, snakemake.params
with (
    job(snakemake.log[0]),
    ArrayReader(source.landmarks) as landmarks,
    ArrayReader(source.pose) as pose,
    ArrayReader(source.textures) as tracked,
    ArrayWriter(snakemake.output.fitted) as out,
):
    aam, reference = Aam.load(source.aam), Reference.load(source.reference)
    heads = load_heads(params.speakers, source.heads)
    model = FittingModel.of_aam(aam, reference, FittingSettings(**params.fitting))
    drift, alignments = DriftSettings(**params.drift), read_alignments(source.alignment)
    utterances, findings = [one for one in read_utterances(source.utterances) if one.id in tracked], []
    for one in progress(utterances, len(utterances), "utterances"):
        frames, points = read_frames(one.media, one.start, one.end), landmarks.array(one.id, "points")
        light, head = (reference_face(tracked, one.id), aam.drift), heads[legal_id(one.speaker)]
        place, rate = Pose.read(pose, one.id), pose.rate(one.id)
        fitted = attempt(one, "fitting", fit_faces, frames, points, place, head, model, reference, light)
        findings += fitted.findings
        if fitted.rejected is not None:
            continue
        found = fitted.value
        if found.diverged.any():
            log.info("%s: %d of %d frames diverged", one.id, found.diverged.sum(), len(found.diverged))
        silent = silent_frames(alignments[one.id], len(found.shape), rate)
        out.add(one.id, {**vars(found), **found.faces(silent, drift, rate=rate).arrays()}, rate, UNITS)
    write_findings(snakemake.output.findings, findings)
