"""Images of the modes of an AAM, which show how one component changes the face."""

from collections.abc import Iterable

import numpy as np

from visualspeech.errors import SettingError
from visualspeech.face.aam.model import Aam
from visualspeech.face.aam.reference import Reference, paint
from visualspeech.face.point_sets import to_points

KINDS = ("shape", "texture", "appearance")
_MARGIN = 0.08  # margin around the mean face, as a share of its width


def mode_pictures(
    aam: Aam, reference: Reference, kind: str, mode: int, sd: float = 2.0, width: int = 200, background: int = 255
) -> list[np.ndarray]:
    """Three images of a mode: mean - sd standard deviations, mean, mean + sd.

    Parameters
    ----------
    kind : ``shape`` (with the mean texture), ``texture`` (at the mean shape) or ``appearance`` (both together)
    mode : which component, from 0
    sd : how far from the mean, in standard deviations of the training faces
    width : width of each image in pixels
    background : grey level around the face

    Returns
    -------
    three (height, width, 3) uint8 RGB; all modes of a model have one size and scale

    Raises
    ------
    SettingError
        The kind is unknown, or the model has no such mode.
    """
    if kind not in KINDS:
        raise SettingError(f"no kind of mode {kind!r}; give one of {', '.join(KINDS)}.")
    bases = {
        "shape": (aam.shape_components, None, aam.shape_variances),
        "texture": (None, aam.texture_components, aam.texture_variances),
        "appearance": (aam.shape_basis, aam.texture_basis, aam.appearance_variances),
    }
    shapes, textures, variances = bases[kind]
    if not 0 <= mode < len(variances):
        raise SettingError(f"there is no {kind} mode {mode}: this AAM has {len(variances)}, counted from 0.")
    distance = sd * np.sqrt(variances[mode])
    faces = [
        (
            aam.shape_mean + (0 if shapes is None else step * shapes[mode]),
            aam.texture_mean + (0 if textures is None else step * textures[mode]),
        )
        for step in (-distance, 0.0, distance)
    ]
    return _painted(aam, reference, faces, width, background)


def face_pictures(
    aam: Aam, reference: Reference, appearance: np.ndarray, width: int = 200, background: int = 255
) -> list[np.ndarray]:
    """Images of the faces with the parameters (T, N), in the size and scale of :func:`mode_pictures`."""
    return _painted(aam, reference, zip(*aam.decode(appearance), strict=True), width, background)


def _painted(aam: Aam, reference: Reference, faces: Iterable, width: int, background: int) -> list[np.ndarray]:
    """Images of faces, each given by its shape (2P,) and its texture (3U,)."""
    low, high = to_points(aam.shape_mean).min(axis=0), to_points(aam.shape_mean).max(axis=0)
    margin = _MARGIN * (high[0] - low[0])
    scale = width / (high[0] - low[0] + 2 * margin)
    canvas = np.full((int(np.ceil((high[1] - low[1] + 2 * margin) * scale)), width, 3), background, np.uint8)
    return [paint(texture, (to_points(shape) - low + margin) * scale, reference, canvas) for shape, texture in faces]
