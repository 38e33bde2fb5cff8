"""AAM fitting beside menpofit 0.7.1: the same training and test frames, the same start, one thread each, in one run.

Run: python -m benchmarks.menpofit PYTHON [PIXELS]

PYTHON is the interpreter of a separate environment, PIXELS the size of our texture (4100)::

    python3.11 -m venv menpofit-env && menpofit-env/bin/pip install -r benchmarks/menpofit-requirements.txt
    python -m benchmarks.menpofit menpofit-env/bin/python

80 frames of 10 GRID recordings train a grey AAM of the whole face (68 points, 15 shape and 30 texture modes); it is
fitted to the 75 frames of another recording. The start is the mean shape under the similarity that fits the landmarks
best, moved by Gaussian noise of 3 pixels. Both sides fit on one scale as menpofit's script does, and ours a second time
from coarse to fine. Prints frames per second (of wall clock; of processor time in brackets), mean distance to the
landmarks in pixels, the root mean square residual in grey levels of each side's own texture model at its points, and
that of one model (ours) at the points of either; then ratios, ours to menpofit's.
"""

import os
import subprocess
import tempfile
import time
from pathlib import Path

import cv2
import numpy as np

from benchmarks.command import grid, run_main
from visualspeech.errors import RejectedUtterance
from visualspeech.face.aam.empca import em_pca, pca
from visualspeech.face.aam.fitting import FittingModel, FittingSettings, fit
from visualspeech.face.aam.fitting.mesh import Mesh
from visualspeech.face.aam.fitting.shapes import ShapeSpace
from visualspeech.face.aam.rows import ArrayRows
from visualspeech.face.landmarks import track
from visualspeech.face.point_sets import to_points, to_vector
from visualspeech.media.reading import read_frames

DIAGONAL, PIXELS = 100, 4100
SHAPE_MODES, TEXTURE_MODES, ITERATIONS = 15, 30, 10
TRAINING, EACH, SPREAD = 10, 8, 3.0
VARIANTS = ("alternating", "project_out")
PASSES = 5  # of our fitting, too fast to be measured in one


def recordings(count: int):
    """Grey frames (T, height, width) and landmarks (T, 68, 2) of the first recordings with a face in every frame."""
    for path in sorted((grid() / "s1").glob("*.mpg")):
        frames = list(read_frames(path))
        try:
            tracked = track(frames, rate=25.0)
        except RejectedUtterance:
            continue
        if tracked.detected.all():
            yield np.stack([cv2.cvtColor(frame, cv2.COLOR_RGB2GRAY) for frame in frames]), tracked.points.astype(float)
            count -= 1
        if not count:
            return


def alike(shapes: np.ndarray) -> np.ndarray:
    """Shapes (n, 68, 2) without similarity: each brought onto their mean, which keeps the size of the first."""
    mean, none = shapes[0], (np.zeros((0, *shapes.shape[1:])), np.zeros(0))
    for _ in range(5):
        space = ShapeSpace.of(mean, *none)
        own, _ = space.parameters(shapes)
        moved = shapes - own[:, None, 2:]
        pair = own[:, :2] * [1, -1] / np.square(own[:, :2]).sum(axis=1, keepdims=True)
        x, y = moved[..., 0], moved[..., 1]
        aligned = np.stack([pair[:, :1] * x - pair[:, 1:] * y, pair[:, 1:] * x + pair[:, :1] * y], axis=-1)
        mean = aligned.mean(axis=0) * np.linalg.norm(space.mean) / np.linalg.norm(aligned.mean(axis=0))
    return aligned


def textures(frames: np.ndarray, points: np.ndarray, mesh: Mesh) -> np.ndarray:
    """Grey levels (n, U) at the pixels of a mesh."""
    places = np.float32(mesh.weights @ points)
    return np.stack(
        [cv2.remap(f, *p.T[:, None].copy(), cv2.INTER_LINEAR)[0] for f, p in zip(frames, places, strict=True)]
    )


def train(frames: np.ndarray, points: np.ndarray, pixels: int):
    """Mesh, shape analysis, texture analysis."""
    shapes = alike(points)
    mesh = Mesh.delaunay(shapes.mean(axis=0), pixels)
    rows = ArrayRows(textures(frames, points, mesh))
    return mesh, pca(to_vector(shapes), components=SHAPE_MODES), em_pca(rows, components=TEXTURE_MODES, iterations=30)


def ready(mesh: Mesh, shape, texture, **settings) -> FittingModel:
    chosen = FittingSettings(**{"iterations": ITERATIONS, "shape_modes": SHAPE_MODES, **settings})
    noise = np.sqrt(texture.total_variance * (1 - texture.energy) / mesh.size)
    shapes = to_points(shape.mean), to_points(shape.components), shape.eigenvalues
    return FittingModel.build(mesh, shapes, (texture.mean, texture.components), noise, chosen)


def left_of(frames, points, mesh, texture) -> np.ndarray:
    """Root mean square residual of the texture model in grey levels (n,), of the faces at some points."""
    away = textures(frames, points, mesh) - texture.mean
    away = away - (away @ texture.components.T) @ texture.components
    return np.sqrt(np.square(away).mean(axis=1))


def theirs(python: str, data: dict) -> dict:
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder, "in.npz"), Path(folder, "out.npz")
        np.savez(source, **data)
        threads = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}
        worker = Path(__file__).with_name("menpofit_worker.py")
        # -P: this folder stays out of the path, or its menpofit.py would stand for the package.
        subprocess.run(
            [python, "-P", worker, source, target], check=True, env={**os.environ, **threads, "PYTHONPATH": ""}
        )
        return dict(np.load(target))


def row(name: str, rate: tuple[float, float], points, truth, own, common) -> tuple[float, ...]:
    distance = np.linalg.norm(points - truth, axis=2).mean()
    print(
        f"{name:38s} {rate[0]:7.0f} ({rate[1]:5.0f}) frames/s  points {distance:5.2f} px  "
        f"reconstruction {own.mean():5.2f}, by one model {common.mean():5.2f} grey levels"
    )
    return *rate, distance, own.mean(), common.mean()


def main(python: str, pixels: int = PIXELS) -> None:
    cv2.setNumThreads(1)
    (test, truth), *others = recordings(TRAINING + 1)
    chosen = [np.linspace(1, len(frames) - 1, EACH).astype(int) for frames, _ in others]
    frames = np.concatenate([f[pick] for (f, _), pick in zip(others, chosen, strict=True)])
    points = np.concatenate([p[pick] for (_, p), pick in zip(others, chosen, strict=True)])
    mesh, shape, texture = train(frames, points, pixels)
    space = ready(mesh, shape, texture).shapes
    similarity, _ = space.parameters(truth)
    starts = space.points(similarity, np.zeros((len(truth), len(space.modes))))
    starts = starts + np.random.default_rng(0).normal(0, SPREAD, (len(truth), 1, 2))
    sizes = {"shape_modes": SHAPE_MODES, "texture_modes": TEXTURE_MODES, "iterations": ITERATIONS}
    data = {"train": frames, "train_points": points, "test": test, "test_points": truth, "starts": starts}
    other = theirs(python, {**data, **sizes, "diagonal": DIAGONAL, "variants": VARIANTS})
    begin = np.linalg.norm(starts - truth, axis=2).mean()
    print(
        f"{len(frames)} training frames, {len(test)} test frames; pixels: {int(other['pixels'])} menpofit, "
        f"{mesh.size} ours; start {begin:.2f} px off; residual of our texture model at the landmarks "
        f"{left_of(test, truth, mesh, texture).mean():.2f} grey levels"
    )
    for variant in VARIANTS:
        at = other[f"{variant}_points"]
        base = row(
            f"{variant}: menpofit",
            tuple(len(test) / other[f"{variant}_seconds"]),
            at,
            truth,
            other[f"{variant}_reconstruction"],
            left_of(test, at, mesh, texture),
        )
        for scales in ((1,), (2, 1)):
            model = ready(mesh, shape, texture, variant=variant, scales=scales)
            began = time.perf_counter(), time.process_time()
            for _ in range(PASSES):
                found = fit(test, starts, model)
            rate = [
                PASSES * len(test) / (now - then)
                for now, then in zip((time.perf_counter(), time.process_time()), began, strict=True)
            ]
            left = left_of(test, found.points, mesh, texture)
            own = row(f"{variant}: ours, scales {scales}", tuple(rate), found.points, truth, left, left)
            ratios = [mine / its for mine, its in zip(own, base, strict=True)]
            print(
                "  ratios: frames/s {:.1f} ({:.1f}), points {:.2f}, reconstruction {:.2f}, by one model {:.2f}".format(
                    *ratios
                )
                + f"; {found.iterations.mean():.1f} iterations per frame, {found.diverged.sum()} diverged"
            )


if __name__ == "__main__":
    run_main(main, __doc__)
