"""Left-to-right chains of states inside phones whose boundaries are known: expected states, and states by duration."""

import numpy as np


def even_states(lengths: np.ndarray, states: int) -> np.ndarray:
    """State of every frame when each phone is shared out evenly: (sum of lengths,) in 0..states - 1.

    A phone with fewer frames than states visits those that the middles of its frames lie in.

    Parameters
    ----------
    lengths : (P,) frames of each phone
    """
    ones = np.ones((len(lengths), states))
    return timed_states(lengths, ones, ones)


def timed_states(lengths: np.ndarray, mean: np.ndarray, variance: np.ndarray) -> np.ndarray:
    """State of every frame when each phone's states last as long as is most likely: (sum of lengths,).

    The durations d = mean + rho variance, with rho such that they fill the phone, are the most likely ones under a
    Gaussian for each state (Yoshimura et al. 1998, Eq. 5-6). None is shorter than a tenth of its mean. A frame has the
    state that its middle lies in.

    Parameters
    ----------
    lengths : (P,) frames of each phone
    mean, variance : (P, S) of the durations of the phone's states, in frames and frames squared
    """
    lengths = np.asarray(lengths)
    rho = (lengths - mean.sum(axis=1)) / variance.sum(axis=1)
    durations = np.maximum(mean + rho[:, None] * variance, 0.1 * mean)
    ends = np.cumsum(durations, axis=1)
    ends *= lengths[:, None] / ends[:, -1:]
    phone = np.repeat(np.arange(len(lengths)), lengths)
    middle = np.arange(len(phone)) - (np.cumsum(lengths) - lengths)[phone] + 0.5
    return (middle[:, None] >= ends[phone, :-1]).sum(axis=1)


def expected_states(density: np.ndarray, lengths: np.ndarray, stay: np.ndarray) -> tuple[np.ndarray, float]:
    """Probability of every state at every frame, and the log-likelihood, of phones whose boundaries are known.

    A phone begins in its first state, ends in its last and leaves none out. One with fewer frames than states cannot:
    its frames are shared out as by :func:`even_states`, and its transitions count nothing.

    Parameters
    ----------
    density : (T, S) log-density of every frame under the states of its own phone
    lengths : (P,) frames of each phone; their sum is T
    stay : (P, S) probability of staying in a state from one frame to the next, inside (0, 1)

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
        place = starts[long, None] + np.minimum(np.arange(lengths[long].max()), lengths[long, None] - 1)
        gamma, each = forward_backward(density[place], lengths[long], stay[long])
        inside = np.arange(place.shape[1]) < lengths[long, None]
        result[place[inside]] = gamma[inside]
        likelihood += float(each.sum())
    return result, likelihood


def forward_backward(density: np.ndarray, lengths: np.ndarray, stay: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Forward-backward in log space over chains of equal topology at once (Rabiner 1989, Eq. 19-27).

    Parameters
    ----------
    density : (P, T, S) log-density of every frame under every state; beyond a chain's length it is not looked at
    lengths : (P,) frames of each chain, at least S
    stay : (P, S) probability of staying; the rest is the probability of going on, from the last state: of the end

    Returns
    -------
    (P, T, S) probability of every state, zero beyond the length; (P,) log-likelihoods
    """
    chains, frames, states = density.shape
    log_stay, log_move = np.log(stay), np.log1p(-stay)
    ahead = np.full((chains, frames, states), -np.inf)
    behind = np.full((chains, frames, states), -np.inf)
    ahead[:, 0, 0] = density[:, 0, 0]
    for t in range(1, frames):
        arrived = np.full((chains, states), -np.inf)
        arrived[:, 1:] = ahead[:, t - 1, :-1] + log_move[:, :-1]
        ahead[:, t] = np.logaddexp(ahead[:, t - 1] + log_stay, arrived) + density[:, t]
    end = np.full((chains, states), -np.inf)
    end[:, -1] = log_move[:, -1]
    for t in range(frames - 1, -1, -1):
        if t + 1 < frames:
            weighed = behind[:, t + 1] + density[:, t + 1]
            onward = np.full((chains, states), -np.inf)
            onward[:, :-1] = weighed[:, 1:] + log_move[:, :-1]
            behind[:, t] = np.logaddexp(weighed + log_stay, onward)
        last = lengths == t + 1
        behind[last, t] = end[last]
        behind[lengths < t + 1, t] = -np.inf
    likelihood = ahead[np.arange(chains), lengths - 1, -1] + log_move[:, -1]
    return np.exp(ahead + behind - likelihood[:, None, None]), likelihood
