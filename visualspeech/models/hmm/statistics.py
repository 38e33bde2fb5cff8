"""Gaussians of states, their densities, and the sums over frames that they are estimated from."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from visualspeech.features.resampling import resample
from visualspeech.models.hmm.chains import even_states, expected_states
from visualspeech.models.hmm.windows import observations

#: Least and greatest probability of staying in a state.
STAY = (0.02, 0.995)


@dataclass(frozen=True)
class Gaussians:
    """States: a diagonal Gaussian over observations, and a Gaussian of the duration, each.

    Parameters
    ----------
    mean, variance : (M, D) of the observations, D = 3N
    duration_mean, duration_variance : (M,) frames, frames squared
    """

    mean: np.ndarray
    variance: np.ndarray
    duration_mean: np.ndarray
    duration_variance: np.ndarray

    def log_density(self, seen: np.ndarray, chosen: np.ndarray) -> np.ndarray:
        """(T, S) log-density of observations (T, D), each under S Gaussians of its own (T, S)."""
        constant = -0.5 * np.log(2 * np.pi * self.variance).sum(axis=1)
        result = constant[chosen]
        for state in range(chosen.shape[1]):
            of_frame = chosen[:, state]
            result[:, state] -= 0.5 * ((seen - self.mean[of_frame]) ** 2 / self.variance[of_frame]).sum(axis=1)
        return result

    def at(self, chosen: np.ndarray) -> "Gaussians":
        """The chosen of them."""
        return Gaussians(*(getattr(self, name)[chosen] for name in Gaussians.__dataclass_fields__))


@dataclass(frozen=True)
class Statistics:
    """Sums over the frames of training utterances.

    Parameters
    ----------
    occupancy : (M,) expected frames of each Gaussian
    first, second : (M, D) sums of observations and of their squares
    visits : (M,) phones that have the Gaussian
    stayed, stayed_squares : (M,) sums over these phones of the expected frames, and of their squares
    long_frames, long_phones : (K, S) expected frames, and phones, of those that have at least as many frames as states
    log_likelihood : of all frames; under even states, of none
    frames : number of frames
    """

    occupancy: np.ndarray
    first: np.ndarray
    second: np.ndarray
    visits: np.ndarray
    stayed: np.ndarray
    stayed_squares: np.ndarray
    long_frames: np.ndarray
    long_phones: np.ndarray
    log_likelihood: float
    frames: int

    def stay(self) -> np.ndarray:
        """(K, S) probability of staying: a phone that visits a state for d frames stays d - 1 times and leaves once."""
        frames = np.maximum(self.long_frames, 1e-10)
        return np.clip(np.where(self.long_phones > 0, 1 - self.long_phones / frames, 0.5), *STAY)

    def gaussians(self, floor: np.ndarray, prior: Gaussians, weight: float = 1e-3) -> Gaussians:
        """The Gaussians of greatest likelihood, held to ``prior`` as if it were ``weight`` frames more of each."""
        total = (self.occupancy + weight)[:, None]
        mean = (self.first + weight * prior.mean) / total
        second = (self.second + weight * (prior.variance + prior.mean**2)) / total
        visits = self.visits + weight
        stayed = (self.stayed + weight * prior.duration_mean) / visits
        squares = (self.stayed_squares + weight * (prior.duration_variance + prior.duration_mean**2)) / visits
        # A state that always lasts equally long may still give way a little: a tenth of its length.
        least = 0.01 * (stayed**2 + 1)
        return Gaussians(mean, np.maximum(second - mean**2, floor), stayed, np.maximum(squares - stayed**2, least))


@dataclass(frozen=True)
class Utterance:
    """One training utterance at the frame rate of the models.

    Parameters
    ----------
    seen : (T, D) observations
    triphones : (P, 3)
    lengths : (P,) frames of each phone
    """

    seen: np.ndarray
    triphones: np.ndarray
    lengths: np.ndarray


def prepare(example: tuple, rate: float, step: int) -> Utterance:
    """An utterance (phone track, values (T, N), their rate in Hz) as observations at another rate."""
    track, values, given = example
    values = resample(np.asarray(values, np.float64), given, rate)
    return Utterance(observations(values, step), *track.runs(len(values), rate))


def accumulate(
    examples: Sequence[tuple],
    find,
    count: int,
    gaussians: Gaussians | None,
    stay: np.ndarray,
    rate: float,
    step: int,
) -> Statistics:
    """One pass over training utterances: the expectation step of Baum-Welch, with the boundaries of phones given.

    Parameters
    ----------
    examples : (phone track, values (T, N), rate in Hz) of every utterance
    find : triphones (P, 3) -> Gaussians (P, S)
    count : number M of Gaussians
    gaussians : of the last iteration; None shares out every phone evenly
    stay : (K, S) probability of staying in a state
    rate, step : frame rate of the models in Hz, and the step of their windows in frames
    """
    phones, states = stay.shape
    sums: dict[str, np.ndarray] = {}
    likelihood, frames = 0.0, 0
    for number in range(len(examples)):
        one = prepare(examples[number], rate, step)
        chosen = find(one.triphones)
        if gaussians is None:
            gamma = np.eye(states)[even_states(one.lengths, states)]
        else:
            density = gaussians.log_density(one.seen, np.repeat(chosen, one.lengths, axis=0))
            gamma, each = expected_states(density, one.lengths, stay[one.triphones[:, 1]])
            likelihood += each
        frames += len(one.seen)
        for name, where, values in _sums(one, chosen, gamma, states):
            if name not in sums:
                size = (phones, states) if name.startswith("long") else (count,)
                sums[name] = np.zeros((*size, *values.shape[1:]))
            np.add.at(sums[name], where, values)
    return Statistics(**sums, log_likelihood=likelihood, frames=frames)


def _sums(one: Utterance, chosen: np.ndarray, gamma: np.ndarray, states: int):
    """What an utterance adds to each sum: (name, where, values)."""
    starts = np.cumsum(one.lengths) - one.lengths
    spent = np.add.reduceat(gamma, starts, axis=0)
    where = chosen.ravel()
    first = np.empty((*chosen.shape, one.seen.shape[1]))
    second = np.empty_like(first)
    squares = one.seen**2
    for phone, (start, length) in enumerate(zip(starts, one.lengths, strict=True)):
        weight = gamma[start : start + length].T
        first[phone] = weight @ one.seen[start : start + length]
        second[phone] = weight @ squares[start : start + length]
    yield "occupancy", where, spent.ravel()
    yield "first", where, first.reshape(len(where), -1)
    yield "second", where, second.reshape(len(where), -1)
    yield "visits", where, np.ones(len(where))
    yield "stayed", where, spent.ravel()
    yield "stayed_squares", where, (spent**2).ravel()
    long = one.lengths >= states
    place = (np.repeat(one.triphones[long, 1], states), np.tile(np.arange(states), long.sum()))
    yield "long_frames", place, spent[long].ravel()
    yield "long_phones", place, np.ones(len(place[0]))
