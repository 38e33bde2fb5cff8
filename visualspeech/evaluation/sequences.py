"""Predicted and recorded lower faces side by side, as the measures need them."""

from collections.abc import Mapping

import numpy as np

from visualspeech.evaluation.metrics import FaceSequence, lip_points
from visualspeech.face.aam.model import Aam
from visualspeech.face.aam.points import LIPS, to_points


def predicted_sequence(appearance: np.ndarray, aam: Aam) -> FaceSequence:
    """What an AAM makes of predicted appearance parameters (T, N) (Fan 2015, Eq. 6 and 7)."""
    vectors = aam.shape_mean + appearance @ aam.shape_basis
    return FaceSequence(
        appearance=appearance,
        shape=aam.shape_parameters(appearance),
        texture=aam.texture_parameters(appearance),
        lips=to_points(vectors)[:, LIPS],
    )


def recorded_sequence(arrays: Mapping[str, np.ndarray]) -> FaceSequence:
    """The recorded face from an utterance's features: ``appearance``, ``shape``, ``texture``, ``points`` (T, 102)."""
    points = lip_points(arrays["points"], range(LIPS.start, LIPS.stop))
    return FaceSequence(arrays["appearance"], arrays["shape"], arrays["texture"], points)
