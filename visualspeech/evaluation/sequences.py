"""Predicted and recorded lower faces in the form that the measures compare."""

from collections.abc import Mapping

import numpy as np

from visualspeech.evaluation.metrics import FaceSequence
from visualspeech.face.aam.model import Aam
from visualspeech.face.point_sets import PointSet, to_points


def predicted_sequence(appearance: np.ndarray, aam: Aam) -> FaceSequence:
    """The lower face decoded from predicted appearance parameters (T, N) (Fan 2015, Eq. 6 and 7)."""
    return FaceSequence(
        appearance=appearance,
        shape=aam.shape_parameters(appearance),
        texture=aam.texture_parameters(appearance),
        lips=aam.points.region(aam.decode_points(appearance), "lips"),
    )


def recorded_sequence(arrays: Mapping[str, np.ndarray], points: PointSet) -> FaceSequence:
    """The recorded face from an utterance's features: ``appearance``, ``shape``, ``texture``, ``points`` (T, 2N)."""
    lips = points.region(to_points(arrays["points"]), "lips")
    return FaceSequence(arrays["appearance"], arrays["shape"], arrays["texture"], lips)
