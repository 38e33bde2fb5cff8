"""Minimum generation error: Gaussians moved so that the trajectories they generate come nearer to the recorded ones.

Wu and Wang (2006), and for visual trajectories Wang et al. (2011): the error of the generated stream, followed back
through the generation to the means and the variances of the states, by gradient descent on the training utterances.
The states of every frame are those that generation would choose, from the times of the phones alone.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from visualspeech.errors import DataError
from visualspeech.features.resampling import resample
from visualspeech.jobs import log
from visualspeech.models.hmm.model import Hmm
from visualspeech.models.hmm.segments import PhoneTrack

#: Decays of the mean gradient and of its square, and what keeps a quotient finite (Kingma and Ba 2015).
_DECAYS, _TINY = (0.9, 0.999), 1e-8


@dataclass(frozen=True)
class Gradient:
    """Generation error of utterances, and how it changes with the Gaussians.

    Parameters
    ----------
    error : half the squared differences, summed over frames and dimensions
    frames : number of frames
    mean : (M, D) derivative by the mean
    log_precision : (M, D) derivative by the logarithm of the precision
    """

    error: float
    frames: int
    mean: np.ndarray
    log_precision: np.ndarray


def refine(hmm: Hmm, training: Sequence[tuple], validation: Sequence[tuple]) -> Hmm:
    """HMMs of least generation error on the validation utterances, along a descent on the training utterances.

    Adam steps on the means, in units of their standard deviations, and on the logarithms of the precisions.

    Parameters
    ----------
    hmm : from :func:`visualspeech.models.hmm.training.fit_tied`
    training, validation : utterances as (:class:`PhoneTrack`, appearance (T, N), its rate in Hz)

    Raises
    ------
    DataError
        There is no training or no validation utterance.
    """
    if not len(training) or not len(validation):
        raise DataError("minimum generation error needs training and validation utterances. Change `split`.")
    settings = hmm.settings
    generator = np.random.default_rng(settings.seed)
    deviation, variance = np.sqrt(hmm.gaussians.variance), hmm.gaussians.variance
    place = np.zeros((2, *variance.shape))
    moments = np.zeros((2, *place.shape))
    best, current, updates, since = hmm, hmm, 0, 0
    lowest = generation_error(hmm, validation)
    history = [["mge", 0, "training_error", generation_error(hmm, training)], ["mge", 0, "validation_error", lowest]]
    log.info("generation error before: training %.4f, validation %.4f", history[0][3], lowest)
    for epoch in range(1, settings.mge_epochs + 1):
        order, total, frames = generator.permutation(len(training)), 0.0, 0
        for start in range(0, len(order), settings.mge_batch_size):
            slope = gradient(
                current, [training[int(number)] for number in order[start : start + settings.mge_batch_size]]
            )
            total, frames, updates = total + slope.error, frames + slope.frames, updates + 1
            # The steps of the means are in deviations of the first model.
            direction = np.stack([slope.mean * deviation, slope.log_precision])
            if not settings.mge_variances:
                direction[1] = 0
            moments, step = _adam(moments, direction / slope.frames, updates)
            place = place - settings.mge_learning_rate * step
            moved = replace(
                hmm.gaussians, mean=hmm.gaussians.mean + deviation * place[0], variance=variance * np.exp(-place[1])
            )
            current = replace(hmm, kind="mge", gaussians=moved)
        error = generation_error(current, validation)
        log.info("epoch %d: training %.4f (during it), validation %.4f", epoch, total / frames, error)
        history += [["mge", epoch, "training_error", total / frames], ["mge", epoch, "validation_error", error]]
        since += 1
        if error < lowest:
            best, lowest, since = current, error, 0
        if since >= settings.mge_patience:
            break
    about = {**hmm.about, "history": [*hmm.about.get("history", []), *history]}
    return replace(best, kind="mge", about=about)


def _adam(moments: np.ndarray, direction: np.ndarray, updates: int) -> tuple[np.ndarray, np.ndarray]:
    """The moments after this update, the ``updates``-th, and the step that Adam makes."""
    decays = np.reshape(_DECAYS, (2, *[1] * direction.ndim))
    moments = decays * moments + (1 - decays) * np.stack([direction, direction**2])
    first, second = moments / (1 - decays**updates)
    return moments, first / (np.sqrt(second) + _TINY)


def generation_error(hmm: Hmm, examples: Sequence[tuple]) -> float:
    """Half the squared difference of generated and recorded streams, a frame, at the HMMs' rate."""
    total, frames = 0.0, 0
    for number in range(len(examples)):
        values, states = _target(hmm, examples[number])
        total += 0.5 * ((hmm.trajectory(states).values - values) ** 2).sum()
        frames += len(values)
    return float(total / max(frames, 1))


def gradient(hmm: Hmm, examples: Sequence[tuple]) -> Gradient:
    """Generation error of utterances and its derivatives.

    With the generated stream c, its error e = c - recorded and b = W R^-1 e, an observation's mean m and precision u
    change the error by u b and by b (m - W c).
    """
    slopes = np.zeros((2, *hmm.gaussians.mean.shape))
    total, frames = 0.0, 0
    for example in examples:
        values, states = _target(hmm, example)
        generated = hmm.trajectory(states)
        error = generated.values - values
        total, frames = total + 0.5 * (error**2).sum(), frames + len(values)
        back = generated.back(error)
        off = hmm.gaussians.mean[states] - generated.observations()
        # Frames that follow each other in one state are summed before they are added to it.
        starts = np.flatnonzero(np.r_[True, states[1:] != states[:-1]])
        for slope, part in zip(slopes, (back, back * off), strict=True):
            np.add.at(slope, states[starts], np.add.reduceat(part, starts, axis=0))
    variance = hmm.gaussians.variance
    return Gradient(float(total), frames, slopes[0] / variance, slopes[1] / variance)


def _target(hmm: Hmm, example: tuple[PhoneTrack, np.ndarray, float]) -> tuple[np.ndarray, np.ndarray]:
    """The recorded stream (T, N) at the HMMs' rate, and the Gaussian of every frame (T,)."""
    track, values, rate = example
    values = resample(np.asarray(values, np.float64), rate, hmm.settings.rate)
    return values, hmm.states_of(*track.runs(len(values), hmm.settings.rate))
