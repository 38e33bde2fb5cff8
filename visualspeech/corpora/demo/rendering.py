"""Rendering of the frames of the demo speaker."""

from collections.abc import Mapping

import numpy as np

from visualspeech.corpora.demo import camera, mouth
from visualspeech.corpora.demo.characters import CHARACTERS, Character
from visualspeech.corpora.demo.deformation import Inverse, deformed
from visualspeech.corpora.demo.motion import Motion
from visualspeech.corpora.demo.portrait import HEIGHT, MIDDLE, SCALE, WIDTH, above_seam, portrait, seam

_STEP = 6
_CELLS = (WIDTH // _STEP + 4, HEIGHT // _STEP + 3)  # columns and rows of the coarse grid, one cell beyond each border
_EYES = ((37, 38, 40, 41, 36, 39), (43, 44, 46, 47, 42, 45))
_LID_TRAVEL = 14.0


def image_points(
    parameters: np.ndarray,
    motion: Motion,
    frame: int,
    character: Character = CHARACTERS["demo"],
    expression: Mapping[str, float] | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """True positions of the 68 points in the canonical (frontal) image and in the frame, each (68, 2) pixels."""
    canonical = mouth.points(parameters)
    for top_outer, top_inner, low_inner, low_outer, *_ in _EYES:
        for top, low in ((top_outer, low_outer), (top_inner, low_inner)):
            canonical[top, 1] += motion.closed_eyes[frame] * (canonical[low, 1] - canonical[top, 1])
    canonical = deformed(canonical, character.proportions, expression or {})
    return canonical, camera.project(canonical, motion.rotation[frame], motion.translation[frame])


class Renderer:
    """Renders frames of one speaker; his images are loaded once."""

    def __init__(self, character: Character = CHARACTERS["demo"]) -> None:
        import cv2

        self._cv2, self._proportions = cv2, character.proportions
        self._at_rest = Inverse(character.proportions)
        images = portrait(character.look)
        # Sampled at half its resolution, the image would alias without a little smoothing.
        self._head = cv2.GaussianBlur(images.head, (0, 0), 0.55)
        cover = images.body[..., 3:] / 255.0
        self._scene = (images.backdrop * (1 - cover) + images.body[..., :3] * cover).astype(np.uint8)
        grain = np.random.default_rng(25).standard_normal((8, HEIGHT, WIDTH, 1), dtype=np.float32)
        self._grain = np.repeat(1.3 * grain, 3, axis=3)
        # Centres of cells of _STEP pixels from one cell before the border, as cv2.resize interpolates between centres.
        x = (np.arange(_CELLS[0]) - 0.5) * _STEP - 0.5
        y = (np.arange(_CELLS[1]) - 0.5) * _STEP - 0.5
        self._nodes = np.stack([np.tile(x, len(y)), np.repeat(y, len(x))], axis=1)

    def frame(
        self, parameters: np.ndarray, motion: Motion, index: int, expression: Mapping[str, float] | None = None
    ) -> np.ndarray:
        """One frame, (HEIGHT, WIDTH, 3) uint8 RGB.

        Parameters
        ----------
        parameters : (6,) mouth parameters of this frame
        motion : movement of the utterance
        index : number of the frame
        expression : movement of the face -> its amount in this frame
        """
        cv2 = self._cv2
        rotation, translation = motion.rotation[index], motion.translation[index]
        canonical = camera.unproject(self._nodes, rotation, translation)
        canonical = self._at_rest(canonical, expression or {})
        reached = (canonical[:, 1] > mouth.TOP) & (np.abs(canonical[:, 0] - MIDDLE) < mouth.REACH)
        upper, lower = canonical.copy(), canonical.copy()
        upper[reached], lower[reached] = mouth.MouthWarp(parameters)(canonical[reached])
        upper = self._dense(upper)
        if motion.closed_eyes[index] > 0.01:
            upper = self._with_lids(upper, self._dense(canonical), motion.closed_eyes[index])

        head = self._sample(upper)
        box = self._box(rotation, translation, expression or {})
        lower, canonical = (self._dense(field)[box] for field in (lower, canonical))
        head[box] = self._with_mouth(head[box], upper[box], lower, canonical, parameters)
        sway = np.float32([[1, 0, 0.35 * translation[0]], [0, 1, 0.2 * translation[1]]])
        scene = cv2.warpAffine(self._scene, sway, (WIDTH, HEIGHT), borderMode=cv2.BORDER_REPLICATE)
        image = self._over(head, scene)
        across = (np.arange(WIDTH, dtype=np.float32) - MIDDLE) / WIDTH
        light = (1 + motion.slope * across)[None, :, None] * motion.gain[index].astype(np.float32)
        image = cv2.multiply(image, np.repeat(light, HEIGHT, axis=0))
        return cv2.add(image, self._grain[(index * 5) % 8], dtype=cv2.CV_8U)

    def _over(self, head: np.ndarray, scene: np.ndarray) -> np.ndarray:
        """The head in front of the scene, float32 RGB."""
        cv2 = self._cv2
        colours, cover = head[..., :3], cv2.cvtColor(head[..., 3], cv2.COLOR_GRAY2RGB)
        behind = scene.astype(np.float32)
        return cv2.add(behind, cv2.multiply(cv2.subtract(colours, behind), cover, scale=1 / 255))

    def _dense(self, coarse: np.ndarray) -> np.ndarray:
        """A field (HEIGHT, WIDTH, 2) float32, interpolated from its values (n, 2) on the coarse grid."""
        columns, rows = _CELLS
        field = coarse.reshape(rows, columns, 2).astype(np.float32)
        dense = self._cv2.resize(field, (columns * _STEP, rows * _STEP), interpolation=self._cv2.INTER_LINEAR)
        return dense[_STEP : _STEP + HEIGHT, _STEP : _STEP + WIDTH]

    def _sample(self, points: np.ndarray) -> np.ndarray:
        """The head image at canonical points (rows, columns, 2), float32 RGB and coverage."""
        pixels = points * np.float32(SCALE) + np.float32((SCALE - 1) / 2)
        return self._cv2.remap(
            self._head, pixels, None, self._cv2.INTER_LINEAR, borderMode=self._cv2.BORDER_CONSTANT
        ).astype(np.float32)

    def _box(self, rotation: np.ndarray, translation: np.ndarray, expression: Mapping) -> tuple[slice, slice]:
        """Rows and columns of the frame that the moving lower face can cover."""
        left, top, right, bottom = MIDDLE - mouth.REACH, mouth.TOP, MIDDLE + mouth.REACH, mouth.BOTTOM
        corners = np.array([[left, top], [right, top], [left, bottom], [right, bottom], [MIDDLE, top]], float)
        if self._proportions or expression:  # curved sides bulge between the corners
            x, y = np.linspace(left, right, 13), np.linspace(top, bottom, 13)
            corners = np.concatenate(
                [[(a, b) for a in x for b in (top, bottom)], [(a, b) for a in (left, right) for b in y]]
            )
            corners = deformed(corners, self._proportions, expression)
        seen = camera.project(corners, rotation, translation)
        x0, y0 = np.maximum(np.floor(seen.min(axis=0)).astype(int), 0)
        x1, y1 = np.ceil(seen.max(axis=0)).astype(int) + 1
        return slice(y0, min(y1, HEIGHT)), slice(x0, min(x1, WIDTH))

    def _with_mouth(self, above, upper, lower, canonical, parameters) -> np.ndarray:
        below = self._sample(lower)
        share_above = above_seam(upper[..., 0], upper[..., 1])
        share_below = 1 - above_seam(lower[..., 0], lower[..., 1])
        both = share_above + share_below
        skin = (share_above[..., None] * above + share_below[..., None] * below) / np.maximum(both, 1e-3)[..., None]
        opening = np.clip(1 - both, 0, 1)
        rows, columns = np.nonzero(opening > 0.002)
        if len(rows):
            distance = upper[rows, columns, 1] - seam(upper[rows, columns, 0])
            colours = mouth.inside(canonical[rows, columns], distance, parameters)
            share = opening[rows, columns, None]
            skin[rows, columns, :3] += share * (colours - skin[rows, columns, :3])
            skin[rows, columns, 3] += share[:, 0] * (255 - skin[rows, columns, 3])
        return skin

    def _with_lids(self, sources: np.ndarray, canonical: np.ndarray, closed: float) -> np.ndarray:
        """The map with the upper eyelids lowered: lid skin is stretched over the eyes, which are squeezed below it."""
        points = mouth.neutral_points()
        sources = sources.copy()
        x, y = canonical[..., 0], canonical[..., 1]
        for eye in _EYES:
            corner_a, corner_b = points[eye[4]], points[eye[5]]
            centre, half = (corner_a + corner_b) / 2, abs(corner_b[0] - corner_a[0]) / 2 + 1.5
            arch = np.clip(1 - ((x - centre[0]) / half) ** 2, 0, None)
            top = centre[1] - (centre[1] - points[eye[0], 1] + 1.5) * 1.1 * arch
            low = centre[1] + (points[eye[2], 1] - centre[1]) * 1.1 * arch
            brow = top - _LID_TRAVEL
            lid = top + 0.93 * closed * (low - top)
            stretched = brow + (y - brow) * (top - brow) / (lid - brow)
            pressed = top + (y - lid) * (low - top) / np.maximum(low - lid, 1e-3)
            moved = np.where(y < lid, stretched, pressed)
            near = (arch > 0) & (y > brow) & (y < low)
            sources[..., 1] = np.where(near, moved, sources[..., 1])
        return sources
