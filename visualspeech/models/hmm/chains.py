"""Left-to-right state sequences inside phones with known boundaries: by forward-backward, and by state durations."""

import numpy as np


def even_states(lengths: np.ndarray, states: int) -> np.ndarray:
    """State of every frame when each phone is divided evenly: (sum of lengths,) in 0..states - 1.

    A phone with fewer frames than states visits the states in which the centres of its frames lie.

    Parameters
    ----------
    lengths : (P,) frames of each phone
    """
    ones = np.ones((len(lengths), states))
    return timed_states(lengths, ones, ones)


def timed_states(lengths: np.ndarray, mean: np.ndarray, variance: np.ndarray) -> np.ndarray:
    """State of every frame when the states of each phone have their most likely durations: (sum of lengths,).

    The durations d = mean + rho variance, with rho such that they fill the phone, are the most likely ones under one
    Gaussian per state (Yoshimura et al. 1998, Eq. 5-6). None is shorter than a tenth of its mean. A frame has the state
    in which its centre lies.

    Parameters
    ----------
    lengths : (P,) frames of each phone
    mean, variance : (P, S) of the state durations, in frames and frames squared
    """
    lengths = np.asarray(lengths)
    rho = (lengths - mean.sum(axis=1)) / variance.sum(axis=1)
    durations = np.maximum(mean + rho[:, None] * variance, 0.1 * mean)
    ends = np.cumsum(durations, axis=1)
    ends *= lengths[:, None] / ends[:, -1:]
    phone = np.repeat(np.arange(len(lengths)), lengths)
    middle = np.arange(len(phone)) - (np.cumsum(lengths) - lengths)[phone] + 0.5
    return (middle[:, None] >= ends[phone, :-1]).sum(axis=1)


def expected_states(density: np.ndarray, lengths: np.ndarray, self_transition: np.ndarray) -> tuple[np.ndarray, float]:
    """Probability of every state at every frame, and the log-likelihood, of phones with known boundaries.

    A phone starts in its first state, ends in its last and skips none. A phone with fewer frames than states cannot:
    its frames are divided as by :func:`even_states`, and its transitions do not contribute to the likelihood.

    Parameters
    ----------
    density : (T, S) log-density of every frame under the states of its own phone
    lengths : (P,) frames of each phone; their sum is T
    self_transition : (P, S) self-transition probability of each state, inside (0, 1)

    Returns
    -------
    (T, S) probabilities, and the log-likelihood of the phones together
    """
    states = density.shape[1]
    result = np.zeros_like(density)
    starts = np.cumsum(lengths) - lengths
    short = np.repeat(lengths < states, lengths)
    at = np.flatnonzero(short)
    result[at, even_states(lengths[lengths < states], states)] = 1
    likelihood = float((density[at] * result[at]).sum())
    long = np.flatnonzero(lengths >= states)
    if len(long):
        frames = starts[long, None] + np.minimum(np.arange(lengths[long].max()), lengths[long, None] - 1)
        gamma, each = forward_backward(density[frames], lengths[long], self_transition[long])
        inside = np.arange(frames.shape[1]) < lengths[long, None]
        result[frames[inside]] = gamma[inside]
        likelihood += float(each.sum())
    return result, likelihood


def forward_backward(
    density: np.ndarray, lengths: np.ndarray, self_transition: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Forward-backward algorithm in log space, over many chains of the same topology (Rabiner 1989, Eq. 19-27).

    Parameters
    ----------
    density : (P, T, S) log-density of every frame under every state; ignored beyond the length of the chain
    lengths : (P,) frames of each chain, at least S
    self_transition : (P, S) self-transition probability; with the remaining probability a state is followed by the
        next, and the last by the end

    Returns
    -------
    (P, T, S) probability of every state, zero beyond the length; (P,) log-likelihoods
    """
    chains, frames, states = density.shape
    log_self, log_next = np.log(self_transition), np.log1p(-self_transition)
    forward = np.full((chains, frames, states), -np.inf)
    backward = np.full((chains, frames, states), -np.inf)
    forward[:, 0, 0] = density[:, 0, 0]
    for t in range(1, frames):
        arrived = np.full((chains, states), -np.inf)
        arrived[:, 1:] = forward[:, t - 1, :-1] + log_next[:, :-1]
        forward[:, t] = np.logaddexp(forward[:, t - 1] + log_self, arrived) + density[:, t]
    end = np.full((chains, states), -np.inf)
    end[:, -1] = log_next[:, -1]
    for t in range(frames - 1, -1, -1):
        if t + 1 < frames:
            weighted = backward[:, t + 1] + density[:, t + 1]
            onward = np.full((chains, states), -np.inf)
            onward[:, :-1] = weighted[:, 1:] + log_next[:, :-1]
            backward[:, t] = np.logaddexp(weighted + log_self, onward)
        last = lengths == t + 1
        backward[last, t] = end[last]
        backward[lengths < t + 1, t] = -np.inf
    likelihood = forward[np.arange(chains), lengths - 1, -1] + log_next[:, -1]
    return np.exp(forward + backward - likelihood[:, None, None]), likelihood
