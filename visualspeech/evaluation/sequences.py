"""Predicted and recorded lower faces in the form that the measures compare."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from visualspeech.evaluation.articulation import Target, articulation_of
from visualspeech.evaluation.scoring import FaceSequence, score
from visualspeech.face.aam.model import Aam
from visualspeech.face.point_sets import PointSet, to_points
from visualspeech.features.resampling import resample
from visualspeech.speech.alignment import Alignment


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


class OnFrames:
    """Predictions brought to the frames of recorded streams, as a video shows them.

    Parameters
    ----------
    predictions, recorded : opened files with the array ``appearance``, at rates of their own
    """

    def __init__(self, predictions, recorded) -> None:
        self._predictions, self._recorded = predictions, recorded

    def array(self, utterance_id: str, name: str) -> np.ndarray:
        """The predicted array at the rate of the recorded one, and of its length."""
        rate, frames = self._recorded.rate(utterance_id), self._recorded.length(utterance_id, name)
        return resample(self._predictions.array(utterance_id, name), self._predictions.rate(utterance_id), rate, frames)


def scores(
    alignments: Mapping[str, Alignment], predictions, targets, aam: Aam, lips: Sequence[Target], drift_kept: bool
) -> Iterator[dict]:
    """The statistics of each utterance: :func:`visualspeech.evaluation.scoring.score`, and those of its articulation.

    Parameters
    ----------
    alignments : by id, of the utterances that are measured
    predictions, targets : opened files: predicted ``appearance``; recorded streams and ``offset``
    lips : thresholds of the speaker
    drift_kept : whether the visual coding has removed no drift
    """
    for one, spoken in alignments.items():
        true, appearance, rate = targets[one], predictions.array(one, "appearance"), targets.rate(one)
        recorded, offset = recorded_sequence(true, aam.points), lip_offset(true["offset"], aam.points)
        row = score(one, predicted_sequence(appearance, aam), recorded, rate, offset, drift_kept)
        yield row | articulation_of(appearance, true["points"], aam, spoken, rate, lips)
