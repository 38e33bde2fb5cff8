"""The AAM of a finished run fitted to its test utterances: how much better its texture fits than at the landmarks.

Run: python -m benchmarks.fitting RESULTS [CODING [UTTERANCES]]

RESULTS is the folder of a corpus (results/grid), CODING a visual coding of it (aam51), UTTERANCES how many of the test
utterances are fitted (10). Prints for each variant and start: frames per second of fitting (wall clock, without
decoding); the residual of the fit in grey levels beside that at the landmarks; movement of the points by fitting, and
their jitter (mean second difference over time) at nose and lips before and after, in pixels; iterations per frame; the
share of frames that diverged.
"""

import time
from pathlib import Path

import cv2
import numpy as np

from benchmarks.command import run_main
from benchmarks.runs import CodingRun, CorpusRun
from visualspeech.face.aam.fitting import FittingModel, FittingSettings, fit, follow
from visualspeech.face.aam.fitting.faces import PoseView
from visualspeech.face.aam.fitting.model import grey
from visualspeech.face.aam.model import Aam
from visualspeech.face.aam.reference import Reference
from visualspeech.face.drift import reference_face
from visualspeech.face.point_sets import to_points
from visualspeech.face.pose import Pose
from visualspeech.media.reading import read_frames

METHODS = (("alternating", fit), ("simultaneous", fit), ("project_out", fit), ("alternating", follow))


def jitter(points: np.ndarray) -> float:
    return float(np.linalg.norm(np.diff(points, 2, axis=0), axis=-1).mean())


def main(results: Path, coding: str = "aam51", count: int = 10) -> None:
    cv2.setNumThreads(1)
    corpus = CorpusRun(results)
    made = CodingRun(corpus, coding)
    aam, reference = Aam.load(made.model), Reference.load(made.reference)
    recordings = []
    with corpus.landmarks() as landmarks, corpus.pose() as pose, made.tracked_faces() as textures:
        for utterance in corpus.of_split("test")[:count]:
            frames = read_frames(utterance.media, utterance.start, utterance.end)
            grey_frames = [cv2.cvtColor(np.ascontiguousarray(frame), cv2.COLOR_RGB2GRAY) for frame in frames]
            own = reference_face(textures, utterance.id)
            shift = to_points(np.float64(own.shape - aam.drift.shape))
            head = corpus.head(utterance.speaker)
            view = PoseView(Pose.read(pose, utterance.id), head, reference.points, shift)
            start = reference.points.select(np.float64(landmarks.array(utterance.id, "points")))
            recordings.append((grey_frames, start, view, grey(own.texture - aam.drift.texture)))
    total = sum(len(frames) for frames, *_ in recordings)
    print(f"{len(recordings)} utterances, {total} frames, {reference.size} pixels, model's own residual", end=" ")
    print(f"{FittingModel.of_aam(aam, reference).noise:.2f} grey levels")
    for variant, method in METHODS:
        begin = time.perf_counter()
        model = FittingModel.of_aam(aam, reference, FittingSettings(variant=variant))
        ready = time.perf_counter()
        found = [method(frames, start, model, view, offset) for frames, start, view, offset in recordings]
        seconds = time.perf_counter() - ready
        pairs = [(fitted.points, start) for fitted, (_, start, _, _) in zip(found, recordings, strict=True)]
        moved = np.mean([np.linalg.norm(a - b, axis=2).mean() for a, b in pairs])
        region = reference.points.region
        nose, lips = (
            [np.mean([jitter(region(pair[which], name)) for pair in pairs]) for which in (1, 0)]
            for name in ("nose", "lips")
        )
        error, before, diverged, iterations = (
            np.concatenate([getattr(fitted, name) for fitted in found])
            for name in ("error", "start_error", "diverged", "iterations")
        )
        print(
            f"{variant} {method.__name__}: {total / seconds:.0f} frames/s (model {ready - begin:.1f} s), residual "
            f"{before.mean():.2f} -> {error.mean():.2f}, moved {moved:.2f} px, jitter nose {nose[0]:.2f} -> "
            f"{nose[1]:.2f}, lips {lips[0]:.2f} -> {lips[1]:.2f} px, {iterations.mean():.1f} iterations, "
            f"{100 * diverged.mean():.1f} % diverged"
        )


if __name__ == "__main__":
    run_main(main, __doc__)
