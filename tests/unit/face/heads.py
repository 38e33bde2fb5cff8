"""A made-up speaker: his head, how he moves it, and where a camera sees his landmarks."""

from dataclasses import dataclass

import numpy as np

from visualspeech.face.camera import project
from visualspeech.face.mean_face import MEAN_FACE

SIZE = (360, 288)
FOCAL = 2.0 * 360
CENTRE = np.array([180.0, 144.0])


@dataclass(frozen=True)
class Recording:
    """A head (68, 3), its poses (T, 3) each, the moving points (T, 68, 3) and what the camera sees (T, 68, 2)."""

    head: np.ndarray
    rotation: np.ndarray
    translation: np.ndarray
    moving: np.ndarray
    points: np.ndarray


def record(frames: int, seed: int, noise: float = 0.0, turn: float = 0.12, mouth: float = 4.0) -> Recording:
    """A speaker with a face of his own who turns by about ``turn`` radians and opens the mouth by ``mouth`` pixels."""
    rng = np.random.default_rng(seed)
    head = MEAN_FACE * 100
    head = head + rng.normal(0, 1.5, head.shape)
    times = np.arange(frames) / 25
    phases = rng.uniform(0, 2 * np.pi, (6, 1))
    speeds = np.array([0.31, 0.23, 0.17, 0.27, 0.21, 0.13])[:, None] * 2 * np.pi
    waves = np.sin(speeds * times + phases).T
    rotation = waves[:, :3] * turn * [1, 1, 0.3] + [0.1, -0.05, 0]
    translation = waves[:, 3:] * [20, 10, 15] + [10, -8, FOCAL]
    opening = mouth * (1 + np.sin(2 * np.pi * 3.1 * times))[:, None]
    moving = np.repeat(head[None], frames, axis=0)
    moving[:, 55:60, 1] += opening
    moving[:, 65:68, 1] += opening
    moving[:, 6:11, 1] += 0.8 * opening
    points = project(moving, rotation, translation, FOCAL, CENTRE)
    return Recording(head, rotation, translation, moving, points + rng.normal(0, noise, points.shape))
