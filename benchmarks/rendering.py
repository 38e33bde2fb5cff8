"""Frames per second of rendering the talking head, on one core, for two frame sizes.

Run: python -m benchmarks.rendering [FRAMES]

FRAMES frames (150) of a drawn face with a moving mouth and a texture of 6000 pixels; the face fills the frame as it
does in GRID (100 pixels wide in 360 x 288). Times are processor time of this process.
"""

import time

import cv2
import numpy as np

from benchmarks.command import run_main
from tests.unit.animation.faces import POINTS, draw, points68, reference
from visualspeech.animation.rendering import Placement, talking_head
from visualspeech.animation.video import Panel, side_by_side
from visualspeech.face.aam.reference import sample_texture

SIZES = ((360, 288), (720, 576))


def main(count: int = 150) -> None:
    cv2.setNumThreads(1)
    texture_grid = reference(6000)
    for width, height in SIZES:
        scale = width / 360
        openings = 6 + 6 * np.sin(np.arange(count) / 3)
        closed = points68(0, scale=75 * scale, centre=(width / 2, 0.48 * height))
        frame = draw(closed, size=(width, height))
        targets = [
            points68(scale * o, drop=scale * o / 2, scale=75 * scale, centre=(width / 2, 0.48 * height))
            for o in openings
        ]
        placement = Placement(np.repeat(POINTS.select(closed)[None], count, 0), POINTS.select(np.stack(targets)))
        textures = [
            sample_texture(draw(points, size=(width, height)), POINTS.select(points), texture_grid)
            for points in targets
        ]
        begin = time.process_time()
        stream = talking_head((frame for _ in range(count)), placement, textures, texture_grid, rate=25.0)
        rendered = sum(1 for _ in side_by_side([Panel("prediction", stream)]))
        spent = time.process_time() - begin
        print(
            f"{width} x {height}: {rendered / spent:.0f} frames/s per panel, {1000 * spent / rendered:.1f} ms per frame"
        )


if __name__ == "__main__":
    run_main(main, __doc__)
