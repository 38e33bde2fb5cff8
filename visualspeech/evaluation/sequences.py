"""Predicted and recorded lower faces in the form that the measures compare."""

from collections.abc import Iterable, Iterator, Mapping

import numpy as np

from visualspeech.evaluation.scoring import FaceSequence, score
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


def lip_offset(offset: np.ndarray, points: PointSet) -> np.ndarray:
    """Offset (20, 2) of the lip points, of the offset (2N,) of an utterance's shape vectors."""
    return points.region(to_points(offset[None]), "lips")[0]


def scores(ids: Iterable[str], predictions, targets, aam: Aam, drift_kept: bool) -> Iterator[dict]:
    """The statistics of each utterance, see :func:`visualspeech.evaluation.scoring.score`.

    Parameters
    ----------
    predictions, targets : opened files: predicted ``appearance``; recorded streams and ``offset``
    drift_kept : whether the visual coding has removed no drift
    """
    for one in ids:
        true = targets[one]
        predicted = predicted_sequence(predictions.array(one, "appearance"), aam)
        recorded, offset = recorded_sequence(true, aam.points), lip_offset(true["offset"], aam.points)
        yield score(one, predicted, recorded, targets.rate(one), offset, drift_kept)
