"""Frames per second of processor time of sampling textures from frames and painting them back, on one core.

Run: python -m benchmarks.texture [VIDEO]

Without a video the frames are random (360 x 288) and decoding is not counted. With one, its frames are decoded too; the
points are synthetic in both cases, for the speed does not depend on the content of a frame. Beside it, for comparison:
one warp for each triangle of the mesh, as image libraries offer it.
"""

import time
from itertools import islice

import cv2
import numpy as np

from benchmarks.command import run_main
from visualspeech.face.aam.reference import Reference, fit_reference, paint, sample_texture
from visualspeech.face.point_sets import read_point_set
from visualspeech.media.reading import read_frames

POINTS = read_point_set("lower_face_51")
FRAMES = 75


def faces(count: int) -> np.ndarray:
    """Points (count, 51, 2) of a face about 110 pixels wide that nods a little."""
    turn = np.arange(17) / 16 * np.pi
    points = np.zeros((68, 2))
    points[:17] = np.stack([-55 * np.cos(turn), 70 * np.sin(turn)], axis=1)
    points[27:31, 1] = np.linspace(0, 26, 4)
    points[31:36] = np.stack([np.linspace(-11, 11, 5), [32, 34, 35, 34, 32]], axis=1)
    ring = np.arange(12) / 12 * 2 * np.pi
    points[48:60] = np.stack([-18 * np.cos(ring), 48 - 7 * np.sin(ring)], axis=1)
    ring = np.arange(8) / 8 * 2 * np.pi
    points[60:68] = np.stack([-14 * np.cos(ring), 48 - 3 * np.sin(ring)], axis=1)
    nod = np.sin(np.arange(count) / 5)[:, None]
    return POINTS.select(points[None] + np.stack([180 + 2 * nod, 120 + 3 * nod], axis=2))


def triangle_by_triangle(frame: np.ndarray, points: np.ndarray, reference: Reference) -> np.ndarray:
    height, width = reference.nearest.shape
    composed = np.zeros((height, width, 3), np.uint8)
    for corners in reference.points.triangles:
        warp = cv2.getAffineTransform(
            points[corners].astype(np.float32), reference.grid_shape[corners].astype(np.float32)
        )
        mask = np.zeros((height, width), np.uint8)
        cv2.fillConvexPoly(mask, np.rint(reference.grid_shape[corners]).astype(np.int32), 1)
        cv2.copyTo(cv2.warpAffine(frame, warp, (width, height)), mask, composed)
    return composed[reference.pixels[:, 0], reference.pixels[:, 1]].T.reshape(-1)


def speed(name: str, function, count: int) -> float:
    begin = time.process_time()
    for number in range(count):
        function(number)
    rate = count / (time.process_time() - begin)
    print(f"{name:44s} {rate:8.0f} frames/s")
    return rate


def main(video: str = "") -> None:
    cv2.setNumThreads(1)
    generator = np.random.default_rng(1)
    if video:
        frames = list(islice(read_frames(video), FRAMES))
    else:
        frames = list(generator.integers(0, 256, (FRAMES, 288, 360, 3), dtype=np.uint8))
    points = faces(len(frames))
    reference = fit_reference([points], POINTS)
    print(f"textures of {reference.size} pixels")
    ours = speed("sample_texture", lambda i: sample_texture(frames[i], points[i], reference), len(frames))
    plain = speed("one warp per triangle", lambda i: triangle_by_triangle(frames[i], points[i], reference), len(frames))
    print(f"ratio: {ours / plain:.1f}")
    textures = [sample_texture(frame, at, reference) for frame, at in zip(frames, points, strict=True)]
    speed("paint", lambda i: paint(textures[i], points[i], reference, frames[i]), len(frames))
    if video:
        begin = time.process_time()
        done = 0
        for number, frame in enumerate(islice(read_frames(video), FRAMES)):
            sample_texture(frame, points[number], reference)
            done += 1
        print(f"{'decoding and sample_texture':44s} {done / (time.process_time() - begin):8.0f} frames/s")


if __name__ == "__main__":
    run_main(main, __doc__)
