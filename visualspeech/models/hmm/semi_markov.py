"""Hidden semi-Markov models inside phones with known boundaries: forward-backward with explicit state durations.

A phone of L frames passes through its S states from left to right, d frames in each, at least one, L in all. A path has
the density of its observations times that of its durations, one Gaussian for each state (Zen et al. 2007, section 2).
"""

from collections.abc import Iterator

import numpy as np

from visualspeech.models.hmm.chains import even_states

_LARGEST = 1 << 21  # numbers in an array of segments; longer phones are passed in several


def duration_density(durations: np.ndarray, mean: np.ndarray, variance: np.ndarray) -> np.ndarray:
    """Log-density of state durations in frames, under one Gaussian each; arrays of shapes that broadcast."""
    return -0.5 * (np.log(2 * np.pi * variance) + (durations - mean) ** 2 / variance)


def expected_durations(
    density: np.ndarray, lengths: np.ndarray, mean: np.ndarray, variance: np.ndarray
) -> tuple[np.ndarray, np.ndarray, float]:
    """Probability of every state at every frame, and expected squared durations, of phones with known boundaries.

    A phone with fewer frames than states cannot pass through all of them: its frames are divided as by
    :func:`visualspeech.models.hmm.chains.even_states`, and the density of this one path is its likelihood.

    Parameters
    ----------
    density : (T, S) log-density of every frame under the states of its own phone
    lengths : (P,) frames of each phone; their sum is T
    mean, variance : (P, S) of the state durations, in frames and frames squared

    Returns
    -------
    (T, S) probabilities, (P, S) expected squares of the durations, and the log-likelihood of the phones together
    """
    states = density.shape[1]
    gamma, squares, likelihood = np.zeros_like(density), np.zeros(mean.shape), 0.0
    starts = np.cumsum(lengths) - lengths
    for length in np.unique(lengths):
        chosen = np.flatnonzero(lengths == length)
        frames = starts[chosen, None] + np.arange(length)
        if length < states:
            path = np.eye(states)[even_states(np.array([length]), states)]
            spent = path.sum(axis=0)
            gamma[frames], squares[chosen] = path, spent**2
            likelihood += (density[frames] * path).sum()
            likelihood += duration_density(spent, mean[chosen], variance[chosen]).sum()
        else:
            found = semi_markov(density[frames], mean[chosen], variance[chosen])
            gamma[frames], squares[chosen] = found[:2]
            likelihood += found[2].sum()
    return gamma, squares, float(likelihood)


def semi_markov(
    density: np.ndarray, mean: np.ndarray, variance: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Forward-backward algorithm of left-to-right HSMMs in log space, over phones of one length (Yu 2010, section 3).

    Parameters
    ----------
    density : (P, L, S) log-density of every frame under every state, L at least S
    mean, variance : (P, S) of the state durations

    Returns
    -------
    (P, L, S) probability of every state, (P, S) expected squares of the durations, (P,) log-likelihoods
    """
    phones, length, states = density.shape
    width = length - states + 1  # numbers of frames at which a state may start: state s at s + 0, ..., s + width - 1
    summed = np.zeros((states, phones, length + 1))
    summed[:, :, 1:] = np.cumsum(density, axis=1).transpose(2, 0, 1)
    durations = duration_density(np.arange(1, width + 1), mean[..., None], variance[..., None]).transpose(1, 0, 2)

    def segments(state: int) -> Iterator[tuple[slice, np.ndarray]]:
        """Log-densities of the segments of a state: some starts (slice), and for these (P, starts, ends) each."""
        per_block = max(_LARGEST // (phones * width), 1)
        first, last = summed[state, :, state : state + width], summed[state, :, state + 1 : state + 1 + width]
        for begin in range(0, width, per_block):
            block = slice(begin, min(begin + per_block, width))
            longer = np.arange(width) - np.arange(begin, block.stop)[:, None]
            lasting = np.where(longer >= 0, durations[state][:, np.maximum(longer, 0)], -np.inf)
            yield block, lasting + last[:, None] - first[:, block, None]

    # Log-density of all frames before the start of a state, and of all frames from there on; states + 1 is the end.
    forward, backward = (np.full((states + 1, phones, width), -np.inf) for _ in range(2))
    forward[0, :, 0], backward[states, :, -1] = 0, 0
    for state in range(states):
        for block, each in segments(state):
            arrived = _logsumexp(forward[state, :, block, None] + each, 1)
            forward[state + 1] = np.logaddexp(forward[state + 1], arrived)
    likelihood = forward[states, :, -1]
    squares = np.zeros((phones, states))
    for state in range(states - 1, -1, -1):
        for block, each in segments(state):
            onward = each + backward[state + 1, :, None]
            backward[state, :, block] = _logsumexp(onward, 2)
            chance = np.exp(forward[state, :, block, None] + onward - likelihood[:, None, None])
            spent = 1 + np.arange(width) - np.arange(block.start, block.stop)[:, None]
            squares[:, state] += (chance * spent**2).sum(axis=(1, 2))
    # A state is on between its start and that of the next one.
    started = np.cumsum(np.exp(forward + backward - likelihood[:, None]), axis=2)
    begun = np.ones((states + 1, phones, length + 1))
    for state in range(states + 1):
        begun[state, :, :state], begun[state, :, state : state + width] = 0, started[state]
    gamma = np.clip(begun[:-1] - begun[1:], 0, 1)[:, :, :length]
    return gamma.transpose(1, 2, 0), squares, likelihood


def _logsumexp(values: np.ndarray, axis: int) -> np.ndarray:
    """Logarithm of the sum of exponentials; -inf where there is nothing but -inf."""
    most = values.max(axis=axis, keepdims=True)
    most = np.where(np.isfinite(most), most, 0)
    with np.errstate(divide="ignore"):
        return np.log(np.exp(values - most).sum(axis=axis)) + most.squeeze(axis)
