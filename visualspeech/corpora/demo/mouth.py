"""The lower face of the demo speaker: its points for given mouth parameters, its warp, and the inside of the mouth."""

from functools import lru_cache

import numpy as np

from visualspeech.corpora.demo.portrait import MIDDLE, SEAM_BEND, neutral_points, seam
from visualspeech.corpora.demo.warp import evaluate, thin_plate

HALF_WIDTH = 27.0
REACH = 96.0  # half the width, in canonical pixels, of the area that moves with the mouth: the jaw and a margin
TOP, BOTTOM = 165, 300
CORNER = 231.5
# Drop of each jaw point as a share of the drop of the chin.
_JAW_SHARE = np.array([0, 0, 0.02, 0.08, 0.25, 0.55, 0.85, 0.97, 1.0, 0.97, 0.85, 0.55, 0.25, 0.08, 0.02, 0, 0])
_LINE = np.array([-0.97, -0.9, -0.66, -0.41, -0.2, 0.0, 0.2, 0.41, 0.66, 0.9, 0.97])
_UPPER = [49, 50, 51, 52, 53]
_LOWER = [55, 56, 57, 58, 59]
_FIXED = np.array(
    [[40, 160], [105, 170], [159.5, 160], [214, 170], [279, 160], [159.5, 194], [159.5, 186], [125, 190], [194, 190]]
    + [[50, 220], [269, 220], [60, 290], [259, 290], [100, 340], [159.5, 345], [219, 340]],
    float,
)


def _profile(x: np.ndarray, half: float) -> np.ndarray:
    """Relative height of the opening across the mouth: 1 in the middle, 0 at the corners."""
    return np.clip(1.0 - (x / half) ** 2, 0.0, 1.0) ** 0.75


def half_width(parameters: np.ndarray) -> float:
    """Half of the mouth's width in canonical pixels."""
    opening, _, width, rounding = parameters[:4]
    spread = 0.10 * max(width, 0.0) + 0.12 * min(width, 0.0)
    return HALF_WIDTH * (1 + spread - 0.14 * rounding - 0.03 * max(opening, 0.0) / 15)


def _lip_lines(x: np.ndarray, parameters: np.ndarray, half: float) -> tuple[np.ndarray, np.ndarray]:
    """Canonical rows of the inner upper and inner lower lip at distances ``x`` from the middle."""
    opening, jaw, _, _, labiodental = parameters[:5]
    rest = CORNER + 0.14 * jaw + SEAM_BEND * np.clip(1 - (x / half) ** 2, 0, None)
    gap = max(opening, 0.0) * _profile(x, half)
    lift = 1.6 * labiodental * _profile(x, half)
    return rest - 0.27 * gap - lift, rest + 0.73 * gap - lift


def points(parameters: np.ndarray) -> np.ndarray:
    """The 68 canonical points (iBUG order) for mouth parameters (6,), shape (68, 2)."""
    rest = neutral_points()
    opening, jaw, _, rounding, labiodental = parameters[:5]
    half = half_width(parameters)
    pressed = np.clip(-opening / 4.0, 0.0, 1.0)
    wide = max(opening, 0.0) / 15.0
    moved = rest.copy()
    moved[:17, 1] += _JAW_SHARE * jaw
    x = (rest[48:68, 0] - MIDDLE) * half / HALF_WIDTH
    moved[48:68, 0] = MIDDLE + x
    upper, lower = _lip_lines(x, parameters, half)
    moved[[48, 54], 1] = upper[[0, 6]]
    thick = seam(rest[48:60, 0]) - rest[48:60, 1]
    upper_scale = 1 - 0.30 * pressed + 0.16 * rounding - 0.12 * wide
    lower_scale = 1 - 0.30 * pressed + 0.16 * rounding - 0.12 * wide - 0.42 * labiodental
    moved[_UPPER, 1] = upper[1:6] - upper_scale * thick[1:6]
    moved[_LOWER, 1] = lower[7:12] - lower_scale * thick[7:12]
    moved[60:65, 1] = upper[12:17]
    moved[65:68, 1] = lower[17:20]
    return moved


@lru_cache(maxsize=1)
def _rest() -> tuple[np.ndarray, np.ndarray]:
    """Positions at rest of the points in the skin beside the lips, (8, 2), and of the line between the lips."""
    soft = [(115, 215), (204, 215), (117, 243), (202, 243), (159.5, 215.5), (159.5, 256), (141, 255), (178, 255)]
    x = MIDDLE + HALF_WIDTH * _LINE
    return np.array(soft, float), np.stack([x, seam(x)], axis=1)


class MouthWarp:
    """Backward warp from the moving face to the face at rest.

    It consists of two smooth fields, one that follows the upper lip and one that follows the lower lip; they agree away
    from the mouth. Pixels that neither field maps to skin are the inside of the mouth.
    """

    def __init__(self, parameters: np.ndarray) -> None:
        rest, moved = neutral_points(), points(parameters)
        soft, line = _rest()
        half = half_width(parameters)
        corner = moved[54] - rest[54]
        jaw, opening = parameters[1], max(parameters[0], 0.0)
        shift = np.array(
            [[-0.4 * corner[0], 0], [0.4 * corner[0], 0], [-0.5 * corner[0], 0.35 * jaw], [0.5 * corner[0], 0.35 * jaw]]
            + [[0, -0.06 * opening], *[[0, 0.7 * jaw + 0.12 * opening]] * 3]
        )
        x = half * _LINE
        inner_upper, inner_lower = _lip_lines(x, parameters, half)
        both_rest = np.concatenate([rest[:17], rest[31:36], rest[[48, 54]], soft, _FIXED])
        both_moved = np.concatenate([moved[:17], moved[31:36], moved[[48, 54]], soft + shift, _FIXED])
        self._fields = []
        for own, heights in ((_UPPER, inner_upper), (_LOWER, inner_lower)):
            source = np.concatenate([both_rest, rest[own], line])
            target = np.concatenate([both_moved, moved[own], np.stack([MIDDLE + x, heights], axis=1)])
            self._fields.append((thin_plate(target, source - target, 0.5), target))

    def __call__(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Positions at rest (m, 2) of canonical points (m, 2), by the upper and by the lower field."""
        # The movement fades out above the base of the nose and beside the face.
        low = np.clip((points[:, 1] - TOP) / 30, 0, 1)
        side = np.clip((REACH - np.abs(points[:, 0] - MIDDLE)) / 20, 0, 1)
        weight = (low * low * (3 - 2 * low) * side)[:, None]
        return tuple(points + weight * evaluate(field, target, points) for field, target in self._fields)


def inside(points: np.ndarray, below_upper_lip: np.ndarray, parameters: np.ndarray) -> np.ndarray:
    """Colours (..., 3) float32 of cavity, teeth and tongue at canonical points (..., 2).

    Parameters
    ----------
    below_upper_lip : (...) distance from the upper lip in canonical pixels; the lip casts a shadow on the teeth
    """
    opening, jaw, _, _, labiodental, tongue = parameters
    x, y = points[..., 0] - MIDDLE, points[..., 1]
    half = half_width(parameters)
    colours = np.empty((*x.shape, 3), np.float32)
    colours[:] = (46, 16, 15)

    tongue_top = 243.5 + 0.85 * jaw - 9.5 * tongue + 0.012 * x**2
    colours = _over(colours, _step(y - tongue_top, 2.0) * _step(19 - np.abs(x), 3.0), (134, 66, 62))
    lower_edge = 237.0 + 0.80 * jaw + 0.006 * x**2
    lower = _step(y - lower_edge, 1.0) * _step(17.5 - np.abs(x), 1.5) * (1 - 0.8 * labiodental)
    colours = _over(colours, lower, _teeth(x, (0.0, 5.2, 10.6, 15.5), 0.86))
    # A raised tip of the tongue is in front of the lower teeth (th, l).
    tip = max(tongue - 0.6, 0.0) / 0.4
    colours = _over(colours, tip * _step(y - 238.6 - 0.02 * x**2, 1.5) * _step(12 - np.abs(x), 3.0), (158, 82, 76))
    upper_edge = 235.6 - 0.0085 * x**2 + 0.35 * np.cos(x * np.pi / 4.1)
    upper = _step(upper_edge - y, 0.9) * _step(23.5 - np.abs(x), 2.0)
    colours = _over(colours, upper, _teeth(x, (0.0, 8.2, 14.6, 20.2), 1.0))
    shadow = 1 - 0.55 * np.exp(-np.maximum(below_upper_lip, 0) / 1.6)
    dim = 1 - 0.6 * np.clip(np.abs(x) / half, 0, 1) ** 2.5
    return colours * (shadow * dim)[..., None].astype(np.float32)


def _step(distance: np.ndarray, width: float) -> np.ndarray:
    return np.clip(distance / width + 0.5, 0.0, 1.0)


def _over(colours: np.ndarray, share: np.ndarray, colour) -> np.ndarray:
    return (colours + share[..., None] * (np.asarray(colour, np.float32) - colours)).astype(np.float32)


def _teeth(x: np.ndarray, borders: tuple, light: float) -> np.ndarray:
    """Colours of a row of teeth with borders at these distances from the middle."""
    gaps = sum(np.exp(-(((np.abs(x) - border) / 0.55) ** 2)) for border in borders)
    return (light * (1 - 0.28 * gaps))[..., None] * np.array([214, 204, 184], np.float32)
