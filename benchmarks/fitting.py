"""The AAM of a finished run fitted to its test utterances: how much better its texture fits than as tracked.

``python -m benchmarks.fitting RESULTS [EXPERIMENT] [UTTERANCES]``, for instance ``results/grid fan2015 10``. For each
variant and start are printed: frames a second of fitting, of wall clock, decoding left out; the residual of the fit in
grey levels beside that at the tracker's points; movement of the points by fitting, and jitter (mean second difference
in time) of nose and lips before and after, in pixels; steps a frame; the share that diverged.
"""

import sys
import time
from pathlib import Path

import cv2
import numpy as np

from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.face.aam.fitting import FittingModel, FittingSettings, fit, follow
from visualspeech.face.aam.fitting.faces import PoseView
from visualspeech.face.aam.fitting.model import grey
from visualspeech.face.aam.model import Aam
from visualspeech.face.aam.reference import Reference
from visualspeech.face.drift import reference_face
from visualspeech.face.head import HeadModel
from visualspeech.face.point_sets import to_points
from visualspeech.face.pose import Pose
from visualspeech.media.reading import read_frames
from visualspeech.storage import ArrayCollection

WAYS = (("alternating", fit), ("simultaneous", fit), ("project_out", fit), ("alternating", follow))


def jitter(points: np.ndarray) -> float:
    return float(np.linalg.norm(np.diff(points, 2, axis=0), axis=-1).mean())


def main(results: str, experiment: str = "fan2015", count: str = "10") -> None:
    cv2.setNumThreads(1)
    corpus, run = Path(results), Path(results, experiment)
    aam, head = Aam.load(run / "aam" / "model.safetensors"), HeadModel.load(run / "pose" / "head.safetensors")
    reference = Reference.load(run / "aam" / "reference.safetensors")
    utterances = of_split(read_utterances(run / "utterances.tsv"), "test")[: int(count)]
    recordings = []
    with (
        ArrayCollection(sorted((corpus / "landmarks").glob("*.h5"))) as landmarks,
        ArrayCollection(sorted((run / "pose").glob("*.h5"))) as pose,
        ArrayCollection(sorted((run / "aam" / "textures").glob("*.h5"))) as textures,
    ):
        for one in utterances:
            frames = read_frames(one.media, one.start, one.end)
            pictures = [cv2.cvtColor(np.ascontiguousarray(frame), cv2.COLOR_RGB2GRAY) for frame in frames]
            own = reference_face(textures, one.id)
            shift = to_points(np.float64(own.shape - aam.drift.shape))
            view = PoseView(Pose.read(pose, one.id), head, reference.points, shift)
            start = reference.points.select(np.float64(landmarks.array(one.id, "points")))
            recordings.append((pictures, start, view, grey(own.texture - aam.drift.texture)))
    total = sum(len(pictures) for pictures, *_ in recordings)
    print(f"{len(recordings)} utterances, {total} frames, {reference.size} pixels, model's own residual", end=" ")
    print(f"{FittingModel.of_aam(aam, reference).noise:.2f} grey levels")
    for variant, way in WAYS:
        began = time.perf_counter()
        model = FittingModel.of_aam(aam, reference, FittingSettings(variant=variant))
        made = time.perf_counter()
        found = [way(pictures, start, model, view, offset) for pictures, start, view, offset in recordings]
        seconds = time.perf_counter() - made
        pairs = [(one.points, start) for one, (_, start, _, _) in zip(found, recordings, strict=True)]
        moved = np.mean([np.linalg.norm(a - b, axis=2).mean() for a, b in pairs])
        region = reference.points.region
        steady = [[np.mean([jitter(region(p[k], name)) for p in pairs]) for k in (1, 0)] for name in ("nose", "lips")]
        error, before, diverged, steps = (
            np.concatenate([getattr(one, name) for one in found])
            for name in ("error", "start_error", "diverged", "iterations")
        )
        print(
            f"{variant} {way.__name__}: {total / seconds:.0f} frames/s (model {made - began:.1f} s), residual "
            f"{before.mean():.2f} -> {error.mean():.2f}, moved {moved:.2f} px, jitter nose {steady[0][0]:.2f} -> "
            f"{steady[0][1]:.2f}, lips {steady[1][0]:.2f} -> {steady[1][1]:.2f} px, {steps.mean():.1f} steps, "
            f"{100 * diverged.mean():.1f} % diverged"
        )


if __name__ == "__main__":
    main(*sys.argv[1:])
