"""Small seeded utterances that phone HMMs can learn: every phone has a pose, shifted by its neighbours, and noise."""

from functools import cache

import numpy as np

from visualspeech.models.hmm.segments import PhoneTrack

PHONES = ("sil", "aa", "b", "iy", "m", "s")


@cache
def utterances(number, seed=0, width=2, phones=8, noise=0.15, rate=25.0, neighbours=1, far=0.0):
    """Examples of HMM training.

    Parameters
    ----------
    neighbours : columns of the contexts on either side of the phone itself
    far : how much the phone two places on shifts the pose
    """
    poses = np.random.default_rng(99).normal(size=(len(PHONES), width))
    generator = np.random.default_rng(seed)
    result = []
    for _ in range(number):
        spoken = np.r_[0, generator.integers(1, len(PHONES), phones), 0]
        padded = np.r_[0, 0, spoken, 0, 0]
        quinphones = np.stack([padded[at : at + len(spoken)] for at in range(5)], axis=1)
        lasting = generator.uniform(0.05, 0.25, len(spoken))
        starts = np.r_[0, np.cumsum(lasting)[:-1]]
        frames = int(lasting.sum() * rate)
        targets = poses[spoken] + 0.3 * poses[quinphones[:, 1]] + 0.3 * poses[quinphones[:, 3]]
        targets = targets + far * poses[quinphones[:, 4]]
        time = (np.arange(frames) + 0.5) / rate
        values = np.stack([np.interp(time, starts + lasting / 2, column) for column in targets.T], axis=1)
        values = 10 * (values + noise * generator.normal(size=values.shape)) + 2
        contexts = quinphones[:, 2 - neighbours : 3 + neighbours]
        result.append((PhoneTrack(contexts, starts, neighbours), values.astype(np.float32), rate))
    return tuple(result)


TRAINING, TEST = utterances(30), utterances(10, seed=7)


def error(hmm, examples=TEST) -> float:
    """Mean squared error of what the HMMs generate for utterances."""
    return np.mean([np.mean((hmm.predict(track, len(seen), rate) - seen) ** 2) for track, seen, rate in examples])


def likelihoods(hmm, stage: str) -> list[float]:
    """Log-likelihood of each iteration of a stage of training."""
    return [value for name, _, figure, value in hmm.about["history"] if (name, figure) == (stage, "log_likelihood")]
