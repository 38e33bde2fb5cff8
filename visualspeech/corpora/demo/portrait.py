"""The face of the demo speaker, who is not a real person, made from a public-domain photograph.

The photograph is :func:`skimage.data.astronaut` (NASA, public domain). It is mirrored, made symmetric and given other
proportions (eye distance, nose, jaw, mouth, hair line) by a thin-plate warp. The mouth is closed; lips, brows, hair,
skin and irises are recoloured; clothes and backdrop are painted. Only the texture of the photograph is left.

Canonical pixels are those of the 320 x 360 output image with the head facing the camera. The head image is stored at
twice that resolution.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from visualspeech.corpora.demo import painting
from visualspeech.corpora.demo.characters import Look
from visualspeech.corpora.demo.warp import evaluate, grid, thin_plate

WIDTH, HEIGHT = 320, 360
SCALE = 2  # pixels of the head image per canonical pixel
MIDDLE = 159.5

# The 68 iBUG points in the photograph, in pixels of its 300 x 300 crop that begins at row 0 and column 60.
_JAW = "119.7 104 120 115.3 121 127 122 138 125 150 131 160 140 168.5 150 175.5 163 178 173 177 184 171 194 163 201 154"
_JAW += " 205.5 143 208.5 131 211 120 212.5 108"
_BROWS = "129 90.5 134 88.5 140 88 147 90.5 154 93 178 93.5 185 92.5 192 92.5 198 93.5 203 96.5"
_NOSE = "165.7 102.5 165.7 111 165.7 119 165.7 127 156 130.5 160.7 132.5 165.7 134 170.7 133 175.5 131.5"
_EYES = (
    "132 101.5 137.5 97.2 146 97.4 153 104 147 105 139 104.6 175.5 105 182 99.5 190 99.7 198.5 104.5 191 107 183 107"
)
_OUTER = "143.5 140 149 139.5 157.5 139.8 164 140.6 170.5 139.8 179 139.6 184.5 140.3 177.5 152.3 170 156 164 156.5"
_OUTER += " 157 155.5 150 151"
_INNER = "144.5 140.6 156 142.8 164 143.8 172 143 183.5 140.8 172 148.8 164 149.6 156 149"
_SOURCE = np.array(" ".join([_JAW, _BROWS, _NOSE, _EYES, _OUTER, _INNER]).split(), float).reshape(68, 2)
# Outline of the head from one ear lobe over the hair to the other, and the hair line on the forehead.
_HAIR = (
    "116 131 112 126 104 110 95 84 94 68 100 55 113 43 128 38 133 30 147 20 166 16 182 15.5 200 21 220 33 233 50 240 70"
)
_HAIR = np.array((_HAIR + " 241 87 235 107 226 124 216 136").split(), float).reshape(-1, 2)
_HAIRLINE = np.array("123 110 126 88 130 76 141 79 152 80 164 81 176 82 188 83 199 85 206 91 210 104".split(), float)
_HAIRLINE = _HAIRLINE.reshape(-1, 2)

# The canonical face: its left half as distance from the middle and height, mirrored for the other half.
_HALF_JAW = [(75, 150), (75, 170), (73.5, 190), (70.5, 210), (65, 229), (55.5, 246), (41, 261), (23, 272), (0, 276.5)]
_HALF_BROW = [(60, 133.5), (52, 126.5), (41, 124.5), (28, 126.5), (17, 130.5)]
_HALF_EYE = [(56, 155), (47.5, 149), (37.5, 148.5), (27, 155.5), (36.5, 158.7), (46.5, 158.7)]
_HALF_NOSE = [(20, 200), (10, 203)]
_BRIDGE = [(0, 152), (0, 164.5), (0, 177), (0, 189.5)]
_NOSE_BASE = 204.5
_HALF_UPPER = [(27, 231.5), (18, 226.6), (8, 223.8), (0, 225.0)]
_HALF_LOWER = [(18, 238.2), (9, 241.8), (0, 242.6)]
SEAM_BEND = 1.3
_HAIR_TARGET = np.array(
    "81 190 77 184 64 160 55 128 53 106 60 84 78 64 98 52 108 42 126 31 152 26 174 25 202 32 228 46 248 68 260 96 "
    "264 122 256 158 244 184 238 196".split(),
    float,
).reshape(-1, 2)
_HAIRLINE_TARGET = np.array(
    "86 158 89 128 97 98 113 91 130 88 148 88 167 89 188 90 210 97 226 126 233 152".split(), float
).reshape(-1, 2)


def _mirrored(half: list[tuple[float, float]]) -> tuple[np.ndarray, np.ndarray]:
    points = np.array(half, float)
    return points * [-1, 1] + [MIDDLE, 0], points + [MIDDLE, 0]


def neutral_points() -> np.ndarray:
    """The 68 points (iBUG order) of the canonical face with the mouth closed, canonical pixels, shape (68, 2)."""
    left, right = _mirrored(_HALF_JAW)
    jaw = np.concatenate([left, right[-2::-1]])
    left, right = _mirrored(_HALF_BROW)
    brows = np.concatenate([left, right[::-1]])
    left, right = _mirrored(_HALF_NOSE)
    nose = np.concatenate([np.array(_BRIDGE, float) + [MIDDLE, 0], left, [[MIDDLE, _NOSE_BASE]], right[::-1]])
    left, right = _mirrored(_HALF_EYE)
    eyes = np.concatenate([left, right[[3, 2, 1, 0, 5, 4]]])
    upper_left, upper_right = _mirrored(_HALF_UPPER)
    lower_left, lower_right = _mirrored(_HALF_LOWER)
    outer = np.concatenate([upper_left, upper_right[-2::-1], lower_right, lower_left[-2::-1]])
    x = MIDDLE + np.array([-24.5, -11, 0, 11, 24.5, 11, 0, -11])
    inner = np.stack([x, seam(x)], axis=1)
    return np.concatenate([jaw, brows, nose, eyes, outer, inner])


def seam(x: np.ndarray) -> np.ndarray:
    """Canonical row of the line between the closed lips, at canonical columns ``x``."""
    return 231.5 + SEAM_BEND * (1.0 - ((x - MIDDLE) / 27.0) ** 2)


@dataclass(frozen=True)
class Portrait:
    """The images from which frames are rendered.

    Parameters
    ----------
    head : (SCALE * HEIGHT, SCALE * WIDTH, 4) uint8, RGB and coverage of the head with mouth and eyes at rest
    backdrop : (HEIGHT, WIDTH, 3) uint8 RGB
    body : (HEIGHT, WIDTH, 4) uint8, RGB and coverage
    """

    head: np.ndarray
    backdrop: np.ndarray
    body: np.ndarray


@lru_cache(maxsize=2)
def portrait(look: Look) -> Portrait:
    """The images of a demo speaker; made once per process, in about a second."""
    import cv2
    import skimage.data

    photograph = np.ascontiguousarray(skimage.data.astronaut()[:300, 60:360]).astype(np.float32)
    maps = _source_maps()
    coverage = _remap(cv2, _coverage(cv2, photograph), maps)
    colours = _remap(cv2, photograph, maps)
    hair, skin = _regions(cv2, colours)
    colours = _recoloured(cv2, colours, hair, skin, look)
    colours = painting.paint_face(colours, neutral_points(), seam, SCALE, look)
    head = np.dstack([colours, 255.0 * coverage])[:, ::-1]  # mirrored
    backdrop, body = painting.backdrop_and_body(WIDTH, HEIGHT, look)
    return Portrait(np.ascontiguousarray(np.clip(head + 0.5, 0, 255)).astype(np.uint8), backdrop, body)


def _remap(cv2, image: np.ndarray, maps: np.ndarray) -> np.ndarray:
    x, y = np.ascontiguousarray(maps[..., 0]), np.ascontiguousarray(maps[..., 1])
    return cv2.remap(image, x, y, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)


def canonical_coordinates() -> tuple[np.ndarray, np.ndarray]:
    """Canonical column and row of every pixel of the head image, each (SCALE * HEIGHT, SCALE * WIDTH)."""
    x = (np.arange(SCALE * WIDTH, dtype=np.float32) + 0.5) / SCALE - 0.5
    y = (np.arange(SCALE * HEIGHT, dtype=np.float32) + 0.5) / SCALE - 0.5
    return np.broadcast_to(x, (len(y), len(x))), np.broadcast_to(y[:, None], (len(y), len(x)))


def above_seam(x: np.ndarray, y: np.ndarray, sharp: float = 1.0) -> np.ndarray:
    """Share (0 to 1) by which points belong to the face above the seam; a sharp edge between the lips, soft beside."""
    beside = np.maximum(np.abs(x - MIDDLE) - 27.0, 0.0)
    return np.clip(0.5 - (y - seam(np.clip(x, MIDDLE - 40, MIDDLE + 40))) / (sharp + 0.8 * beside), 0.0, 1.0)


def _source_maps() -> np.ndarray:
    """Photograph coordinates of every pixel of the head image, (rows, columns, 2) float32."""
    import cv2

    points = neutral_points()
    upper, lower = [*range(0, 55), *range(60, 65)], [*range(0, 49), *range(54, 61), *range(64, 68)]
    x, y = canonical_coordinates()
    nodes, rows, columns = grid(-4, -4, WIDTH + 4, HEIGHT + 4, 4)
    fields = []
    for own in (upper, lower):
        target = np.concatenate([points[own], _HAIR_TARGET, _HAIRLINE_TARGET])
        source = np.concatenate([_SOURCE[own], _HAIR, _HAIRLINE])
        coarse = evaluate(thin_plate(target, source, 4.0), target, nodes).reshape(rows, columns, 2)
        at = [np.ascontiguousarray((axis + 4) / 4, dtype=np.float32) for axis in (x, y)]
        fields.append(cv2.remap(coarse.astype(np.float32), *at, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE))
    share = above_seam(x, y, 0.5)[..., None]
    return (share * fields[0] + (1 - share) * fields[1]).astype(np.float32)


def _coverage(cv2, photograph: np.ndarray) -> np.ndarray:
    """Coverage (0 to 1) of the head in the photograph: a drawn outline, refined by the colour of the backdrop."""
    outline = np.concatenate([_HAIR, _SOURCE[13:2:-1]])
    inside = np.zeros(photograph.shape[:2], np.uint8)
    cv2.fillPoly(inside, [np.round(outline * 16).astype(np.int32)], 255, cv2.LINE_AA, 4)
    drawn = cv2.GaussianBlur(cv2.erode(inside, np.ones((3, 3), np.uint8)).astype(np.float32) / 255, (0, 0), 0.8)
    wide = cv2.dilate(inside, np.ones((9, 9), np.uint8)).astype(np.float32) / 255
    outside = 1.0 - cv2.dilate(inside, np.ones((15, 15), np.uint8)).astype(np.float32) / 255
    weight = cv2.GaussianBlur(outside, (0, 0), 12) + 1e-3
    behind = cv2.GaussianBlur(photograph * outside[..., None], (0, 0), 12) / weight[..., None]
    different = np.clip((np.abs(photograph - behind).max(axis=2) - 14) / 40, 0, 1)
    core = cv2.erode(inside, np.ones((7, 7), np.uint8)).astype(np.float32) / 255
    found = np.maximum(core, np.minimum(wide, different))
    # Jaw and ears are in front of the suit and the neck, where only the drawn outline is reliable.
    y = np.arange(len(found))[:, None]
    low = np.clip((y - 95) / 20.0, 0, 1)
    return ((1 - low) * found + low * drawn).astype(np.float32)


def _regions(cv2, colours: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Masks (0 to 1) of hair and skin in the head image, with soft edges."""
    points = neutral_points()
    face = np.concatenate([points[0:17], _HAIRLINE_TARGET[::-1]])
    mask = np.zeros(colours.shape[:2], np.uint8)
    cv2.fillPoly(mask, [np.round((face * SCALE + 0.5) * 16).astype(np.int32)], 255, cv2.LINE_AA, 4)
    soft = cv2.GaussianBlur(mask.astype(np.float32) / 255, (0, 0), 5)
    # Skin is redder and lighter than hair, which separates them near the drawn border.
    smooth = cv2.GaussianBlur(colours, (0, 0), 1.5)
    redness = np.clip((smooth[..., 0] - 150) / 50, 0, 1)
    near = 4 * soft * (1 - soft)
    skin = (1 - near) * soft + near * redness
    x, y = canonical_coordinates()
    # Below the hair, everything up to the outline is skin.
    low = np.clip((y - 178) / 8, 0, 1) * np.maximum(np.clip((y - 196) / 6, 0, 1), redness)
    skin = np.maximum(skin, low).astype(np.float32)
    return 1.0 - skin, skin


def _recoloured(cv2, colours: np.ndarray, hair: np.ndarray, skin: np.ndarray, look: Look) -> np.ndarray:
    grey = colours @ np.array([0.3, 0.59, 0.11], np.float32)
    detail = grey - cv2.GaussianBlur(grey, (0, 0), 12)
    dark = (look.hair_light + 0.22 * grey + 0.30 * detail)[..., None] * np.array(look.hair, np.float32)
    smooth = cv2.bilateralFilter(colours, 9, 18, 5)
    tanned = smooth * np.array(look.skin, np.float32) + np.array([4, 2, 4], np.float32)
    tanned = 128 + 1.06 * (tanned - 128)
    return hair[..., None] * dark + skin[..., None] * tanned
