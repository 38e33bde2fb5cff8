"""A made-up face of 68 points, its speech-like movement, and smooth pictures, for tests and drawings."""

import numpy as np

from visualspeech.face.point_sets import read_point_set

POINTS = read_point_set("lower_face_51")


def generic_face(opening: float = 0.03) -> np.ndarray:
    """68 points (x, y) in the iBUG order, the face 1 wide, symmetric about x = 0; y points down."""
    turn = np.arange(17) / 16 * np.pi
    jaw = np.stack([-0.5 * np.sign(np.cos(turn)) * np.abs(np.cos(turn)) ** 0.8, 0.68 * np.sin(turn) ** 0.9], axis=1)
    brow = np.stack([np.linspace(-0.4, -0.09, 5), -0.14 - 0.05 * np.sin(np.linspace(0.3, 2.6, 5))], axis=1)
    bridge = np.stack([np.zeros(4), [0.0, 0.09, 0.175, 0.26]], axis=1)
    wings = np.array([[-0.11, 0.325], [-0.055, 0.34], [0, 0.35], [0.055, 0.34], [0.11, 0.325]])
    eye = np.array([[-0.31, 0], [-0.26, -0.03], [-0.2, -0.03], [-0.14, 0.01], [-0.2, 0.03], [-0.26, 0.03]])
    upper = np.array([[-0.18, 0.47], [-0.11, 0.44], [-0.045, 0.425], [0, 0.435]])
    lower = np.array([[0, 0.55], [-0.045, 0.545], [-0.11, 0.52]]) + [0, opening]
    inner = np.array([[-0.155, 0.472], [-0.05, 0.462], [0, 0.467]])
    inner_low = np.array([[0, 0.475], [-0.05, 0.47]]) + [0, opening]
    flip = np.array([-1, 1])
    outer = np.concatenate([upper, upper[2::-1] * flip, lower[:0:-1] * flip, lower])
    inside = np.concatenate([inner, inner[1::-1] * flip, inner_low[:0:-1] * flip, inner_low])
    eyes = np.concatenate([eye, eye[[3, 2, 1, 0, 5, 4]] * flip])
    return np.concatenate([jaw, brow, brow[::-1] * flip, bridge, wings, eyes, outer, inside])


def moving_faces(frames: int, seed: int = 0, width: float = 100.0) -> np.ndarray:
    """Faces (frames, 68, 2) in pixels around (100, 60): the jaw opens, the lips round, points jitter."""
    generator = np.random.default_rng(seed)
    jaw, rounding = generator.standard_normal((2, frames, 1))
    face = generic_face()
    down = np.zeros(68)
    down[[6, 7, 8, 9, 10, 55, 56, 57, 58, 59, 65, 66, 67]] = 1
    wide = np.zeros(68)
    wide[48:68] = face[48:68, 0]
    moved = np.repeat(face[None], frames, axis=0)
    moved[:, :, 1] += 0.02 * (jaw + 1.5) * down
    moved[:, :, 0] += 0.1 * rounding * wide
    return moved * width + [100, 60] + generator.normal(0, 0.1, moved.shape)


def smooth_picture(height: int, width: int, seed: int = 0) -> np.ndarray:
    """A picture (height, width, 3) uint8 without detail finer than about ten pixels."""
    generator = np.random.default_rng(seed)
    x, y = np.meshgrid(np.arange(width), np.arange(height))
    picture = np.full((height, width, 3), 128.0)
    for channel in range(3):
        for _ in range(4):
            fx, fy, phase = generator.uniform(-0.08, 0.08), generator.uniform(-0.08, 0.08), generator.uniform(0, 6.3)
            picture[..., channel] += 25 * np.sin(fx * x + fy * y + phase)
    return np.clip(np.rint(picture), 0, 255).astype(np.uint8)
