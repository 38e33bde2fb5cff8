"""Gaussians of states, their densities, and the sufficient statistics that they are estimated from."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from visualspeech.features.resampling import resample
from visualspeech.models.hmm.chains import even_states, expected_states
from visualspeech.models.hmm.segments import Example
from visualspeech.models.hmm.semi_markov import expected_durations
from visualspeech.models.hmm.tying import units
from visualspeech.models.trajectory.windows import observations

#: Bounds of the self-transition probability of a state.
SELF_TRANSITION = (0.02, 0.995)
_TOGETHER = 16  # utterances that HSMMs pass at once


@dataclass(frozen=True)
class Gaussians:
    """Distributions of states: a diagonal Gaussian of the observations and a Gaussian of the duration for each.

    Parameters
    ----------
    mean, variance : (M, D) of the observations, D = 3N
    duration_mean, duration_variance : (M,) frames, frames squared
    """

    mean: np.ndarray
    variance: np.ndarray
    duration_mean: np.ndarray
    duration_variance: np.ndarray

    def log_density(self, observed: np.ndarray, chosen: np.ndarray) -> np.ndarray:
        """(T, S) log-density of observations (T, D), each under its own S Gaussians, of numbers (T, S)."""
        constant = -0.5 * np.log(2 * np.pi * self.variance).sum(axis=1)
        result = constant[chosen]
        for state in range(chosen.shape[1]):
            of_frame = chosen[:, state]
            result[:, state] -= 0.5 * ((observed - self.mean[of_frame]) ** 2 / self.variance[of_frame]).sum(axis=1)
        return result

    def at(self, chosen: np.ndarray) -> "Gaussians":
        """The Gaussians of some numbers, of any shape (...)."""
        return Gaussians(*(getattr(self, name)[chosen] for name in Gaussians.__dataclass_fields__))


@dataclass(frozen=True)
class Statistics:
    """Sufficient statistics of training utterances.

    Parameters
    ----------
    occupancy : (M,) expected frames of each Gaussian
    first, second : (M, D) sums of observations and of their squares
    visits : (M,) phones that have the Gaussian
    durations, squared_durations : (M,) sums over these phones of the expected frames, and of their squares: with
        geometric durations the squares of what is expected, with Gaussian ones what is expected of the squares
    long_frames, long_phones : (K, S) expected frames and number of phones, of phones with at least as many frames as
        states
    log_likelihood : of all frames; 0 where phones are divided evenly
    frames : number of frames
    """

    occupancy: np.ndarray
    first: np.ndarray
    second: np.ndarray
    visits: np.ndarray
    durations: np.ndarray
    squared_durations: np.ndarray
    long_frames: np.ndarray
    long_phones: np.ndarray
    log_likelihood: float
    frames: int

    def self_transition(self) -> np.ndarray:
        """(K, S) self-transition probability: of d frames in a state, d - 1 are followed by the same state."""
        frames = np.maximum(self.long_frames, 1e-10)
        return np.clip(np.where(self.long_phones > 0, 1 - self.long_phones / frames, 0.5), *SELF_TRANSITION)

    def gaussians(self, floor: np.ndarray, prior: Gaussians, weight: float = 1e-3) -> Gaussians:
        """Maximum a posteriori estimates; ``prior`` counts as ``weight`` additional frames of each Gaussian."""
        total = (self.occupancy + weight)[:, None]
        mean = (self.first + weight * prior.mean) / total
        second = (self.second + weight * (prior.variance + prior.mean**2)) / total
        visits = self.visits + weight
        duration = (self.durations + weight * prior.duration_mean) / visits
        squares = (self.squared_durations + weight * (prior.duration_variance + prior.duration_mean**2)) / visits
        # The duration of a state that is always equally long may still vary by a tenth.
        minimum = 0.01 * (duration**2 + 1)
        return Gaussians(
            mean, np.maximum(second - mean**2, floor), duration, np.maximum(squares - duration**2, minimum)
        )


@dataclass(frozen=True)
class Utterance:
    """One training utterance at the frame rate of the models.

    Parameters
    ----------
    observed : (T, D) observations
    contexts : (P, C) phones with their neighbours, or divisions of phones
    lengths : (P,) frames of each row
    units : (P,) the phones themselves, or their divisions (:func:`visualspeech.models.hmm.tying.units`)
    """

    observed: np.ndarray
    contexts: np.ndarray
    lengths: np.ndarray
    units: np.ndarray


def prepare(example: Example, rate: float, step: int) -> Utterance:
    """A training utterance at ``rate`` Hz, with windows of ``step`` frames."""
    track, values, given = example
    values = resample(np.asarray(values, np.float64), given, rate)
    contexts, lengths = track.runs(len(values), rate)
    return Utterance(observations(values, step), contexts, lengths, units(contexts, track.centre, track.divisions))


def _joined(utterances: Sequence[Utterance]) -> Utterance:
    """Several utterances, one after the other."""
    if len(utterances) == 1:
        return utterances[0]
    names = Utterance.__dataclass_fields__
    return Utterance(**{name: np.concatenate([getattr(one, name) for one in utterances]) for name in names})


def accumulate(
    examples: Sequence[Example],
    find: Callable[[np.ndarray], np.ndarray],
    count: int,
    gaussians: Gaussians | None,
    self_transition: np.ndarray,
    rate: float,
    step: int,
    durations: str = "geometric",
) -> Statistics:
    """One pass over training utterances: the expectation step of Baum-Welch with known phone boundaries.

    Parameters
    ----------
    examples : training utterances
    find : from contexts (P, C) to Gaussians (P, S)
    count : number M of Gaussians
    gaussians : of the last iteration; None divides every phone evenly among its states
    self_transition : (K, S) self-transition probabilities of the states of each unit: phone, or division of a phone
    rate, step : frame rate of the models in Hz, and the step of their windows in frames
    durations : of the states: ``geometric``, from the self-transition probabilities, or ``gaussian``, explicit
    """
    count_of_units, states = self_transition.shape
    sums: dict[str, np.ndarray] = {}
    likelihood, frames = 0.0, 0
    explicit = durations == "gaussian"
    # Phones of one length are passed together; in several utterances there are more of them.
    together = _TOGETHER if explicit else 1
    for begin in range(0, len(examples), together):
        batch = range(begin, min(begin + together, len(examples)))
        one = _joined([prepare(examples[number], rate, step) for number in batch])
        chosen, squares = find(one.contexts), None
        if gaussians is None:
            gamma = np.eye(states)[even_states(one.lengths, states)]
        else:
            density = gaussians.log_density(one.observed, np.repeat(chosen, one.lengths, axis=0))
            if explicit:
                lasting = gaussians.duration_mean[chosen], gaussians.duration_variance[chosen]
                gamma, squares, each = expected_durations(density, one.lengths, *lasting)
            else:
                gamma, each = expected_states(density, one.lengths, self_transition[one.units])
            likelihood += each
        frames += len(one.observed)
        for name, where, values in _sums(one, chosen, gamma, squares, states):
            if name not in sums:
                size = (count_of_units, states) if name.startswith("long") else (count,)
                sums[name] = np.zeros((*size, *values.shape[1:]))
            np.add.at(sums[name], where, values)
    return Statistics(**sums, log_likelihood=likelihood, frames=frames)


def _sums(
    one: Utterance, chosen: np.ndarray, gamma: np.ndarray, squares: np.ndarray | None, states: int
) -> Iterator[tuple]:
    """Contributions of an utterance: (name of the sum, indices, values)."""
    starts = np.cumsum(one.lengths) - one.lengths
    spent = np.add.reduceat(gamma, starts, axis=0)
    where = chosen.ravel()
    first = np.empty((*chosen.shape, one.observed.shape[1]))
    second = np.empty_like(first)
    observed_squares = one.observed**2
    for phone, (start, length) in enumerate(zip(starts, one.lengths, strict=True)):
        weight = gamma[start : start + length].T
        first[phone] = weight @ one.observed[start : start + length]
        second[phone] = weight @ observed_squares[start : start + length]
    yield "occupancy", where, spent.ravel()
    yield "first", where, first.reshape(len(where), -1)
    yield "second", where, second.reshape(len(where), -1)
    yield "visits", where, np.ones(len(where))
    yield "durations", where, spent.ravel()
    yield "squared_durations", where, (spent**2 if squares is None else squares).ravel()
    long = one.lengths >= states
    cell = (np.repeat(one.units[long], states), np.tile(np.arange(states), long.sum()))
    yield "long_frames", cell, spent[long].ravel()
    yield "long_phones", cell, np.ones(len(cell[0]))
