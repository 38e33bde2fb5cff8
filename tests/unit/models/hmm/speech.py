"""Small seeded utterances whose streams phone HMMs can learn: every phone a pose, bent by its neighbours, and noise."""

from functools import cache

import numpy as np

from visualspeech.models.hmm.segments import PhoneTrack

PHONES = ("sil", "aa", "b", "iy", "m", "s")


@cache
def utterances(number, seed=0, width=2, phones=8, noise=0.15, rate=25.0):
    poses = np.random.default_rng(99).normal(size=(len(PHONES), width))
    generator = np.random.default_rng(seed)
    result = []
    for _ in range(number):
        spoken = np.r_[0, generator.integers(1, len(PHONES), phones), 0]
        triphones = np.stack([np.r_[0, spoken[:-1]], spoken, np.r_[spoken[1:], 0]], axis=1)
        lasting = generator.uniform(0.05, 0.25, len(spoken))
        starts = np.r_[0, np.cumsum(lasting)[:-1]]
        frames = int(lasting.sum() * rate)
        targets = poses[spoken] + 0.3 * poses[triphones[:, 0]] + 0.3 * poses[triphones[:, 2]]
        time = (np.arange(frames) + 0.5) / rate
        values = np.stack([np.interp(time, starts + lasting / 2, column) for column in targets.T], axis=1)
        values = 10 * (values + noise * generator.normal(size=values.shape)) + 2
        result.append((PhoneTrack(triphones, starts), values.astype(np.float32), rate))
    return tuple(result)
