"""Minimum generation error (MGE) training: the error of generated trajectories, minimised over the Gaussians.

Wu and Wang (2006), and for visual trajectories Wang et al. (2011): the error of the generated stream is propagated back
through the generation to the means and variances of the states, which are updated by gradient descent on the training
utterances. The state of every frame is the one that generation would choose, from the phone times alone.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from visualspeech.errors import DataError
from visualspeech.jobs import log
from visualspeech.models.hmm.model import Hmm
from visualspeech.models.hmm.segments import Example

#: Decay rates of Adam's first and second moment, and its epsilon (Kingma and Ba 2015).
_DECAYS, _EPSILON = (0.9, 0.999), 1e-8


@dataclass(frozen=True)
class Gradient:
    """Generation error of utterances, and its derivatives by the parameters of the Gaussians.

    Parameters
    ----------
    error : half the squared differences, summed over frames and dimensions
    frames : number of frames of the recordings
    mean : (M, D) derivative by the mean
    log_precision : (M, D) derivative by the logarithm of the precision
    """

    error: float
    frames: int
    mean: np.ndarray
    log_precision: np.ndarray


def refine(hmm: Hmm, training: Sequence[Example], validation: Sequence[Example]) -> Hmm:
    """MGE-trained HMMs: those of the epoch with the lowest generation error on the validation utterances.

    Adam updates the means, in units of their standard deviations, and the logarithms of the precisions.

    Parameters
    ----------
    hmm : from :func:`visualspeech.models.hmm.training.fit_tied`
    training, validation : utterances as (:class:`PhoneTrack`, values (T, N), their rate in Hz)

    Raises
    ------
    DataError
        There is no training utterance or no validation utterance.
    """
    if not len(training) or not len(validation):
        raise DataError("MGE training needs training and validation utterances. Change `split`.")
    settings = hmm.settings
    generator = np.random.default_rng(settings.seed)
    deviation, variance = np.sqrt(hmm.gaussians.variance), hmm.gaussians.variance
    offset = np.zeros((2, *variance.shape))
    moments = np.zeros((2, *offset.shape))
    best, current, updates, since = hmm, hmm, 0, 0
    lowest = generation_error(hmm, validation)
    history = [["mge", 0, "training_error", generation_error(hmm, training)], ["mge", 0, "validation_error", lowest]]
    log.info("generation error before MGE training: training %.4f, validation %.4f", history[0][3], lowest)
    for epoch in range(1, settings.mge_epochs + 1):
        order, total, frames = generator.permutation(len(training)), 0.0, 0
        for start in range(0, len(order), settings.mge_batch_size):
            slope = gradient(
                current, [training[int(number)] for number in order[start : start + settings.mge_batch_size]]
            )
            total, frames, updates = total + slope.error, frames + slope.frames, updates + 1
            # The steps of the means are in standard deviations of the initial model.
            direction = np.stack([slope.mean * deviation, slope.log_precision])
            if not settings.mge_variances:
                direction[1] = 0
            moments, step = _adam(moments, direction / slope.frames, updates)
            offset = offset - settings.mge_learning_rate * step
            moved = replace(
                hmm.gaussians, mean=hmm.gaussians.mean + deviation * offset[0], variance=variance * np.exp(-offset[1])
            )
            current = replace(hmm, gaussians=moved)
        error = generation_error(current, validation)
        log.info("epoch %d: training %.4f (during the epoch), validation %.4f", epoch, total / frames, error)
        history += [["mge", epoch, "training_error", total / frames], ["mge", epoch, "validation_error", error]]
        since += 1
        if error < lowest:
            best, lowest, since = current, error, 0
        if since >= settings.mge_patience:
            break
    about = {**hmm.about, "history": [*hmm.about.get("history", []), *history]}
    return replace(best, about=about)


def _adam(moments: np.ndarray, direction: np.ndarray, updates: int) -> tuple[np.ndarray, np.ndarray]:
    """Adam's moments after update number ``updates``, and its step."""
    decays = np.reshape(_DECAYS, (2, *[1] * direction.ndim))
    moments = decays * moments + (1 - decays) * np.stack([direction, direction**2])
    first, second = moments / (1 - decays**updates)
    return moments, first / (np.sqrt(second) + _EPSILON)


def generation_error(hmm: Hmm, examples: Sequence[Example]) -> float:
    """Half the squared difference of generated and recorded frames, per frame of the recording.

    Generated frames are read as those of a prediction are. The mean difference of an utterance has the weight
    ``mge_offset_weight``.
    """
    total, frames = 0.0, 0
    for number in range(len(examples)):
        track, values, rate = examples[number]
        generated = hmm.trajectory(hmm.states_at(track, len(values), rate)).values
        error = hmm.read(generated, len(values), rate) - values
        total += 0.5 * (error * _weighted(error, hmm.settings.mge_offset_weight)).sum()
        frames += len(values)
    return float(total / max(frames, 1))


def gradient(hmm: Hmm, examples: Sequence[Example]) -> Gradient:
    """Generation error of utterances and its derivatives.

    With the generated stream c, its frames A c, the derivative e of the error by these and b = W R^-1 A' e, the
    derivatives by the mean m and the precision u of an observation are u b and b (m - W c).
    """
    slopes = np.zeros((2, *hmm.gaussians.mean.shape))
    total, frames = 0.0, 0
    for track, values, rate in examples:
        states = hmm.states_at(track, len(values), rate)
        generated = hmm.trajectory(states)
        error = hmm.read(generated.values, len(values), rate) - values
        slope = _weighted(error, hmm.settings.mge_offset_weight)
        total, frames = total + 0.5 * (error * slope).sum(), frames + len(values)
        back = generated.back(hmm.back(slope, len(states), rate))
        off = hmm.gaussians.mean[states] - generated.observations()
        # Consecutive frames in one state are summed before they are added to it.
        starts = np.flatnonzero(np.r_[True, states[1:] != states[:-1]])
        for sums, part in zip(slopes, (back, back * off), strict=True):
            np.add.at(sums, states[starts], np.add.reduceat(part, starts, axis=0))
    variance = hmm.gaussians.variance
    return Gradient(float(total), frames, slopes[0] / variance, slopes[1] / variance)


def _weighted(error: np.ndarray, offset_weight: float) -> np.ndarray:
    """The derivative of the generation error of an utterance by its errors (T, N): their mean weighted differently."""
    return error + (offset_weight - 1) * error.mean(axis=0)
