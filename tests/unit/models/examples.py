"""Small seeded utterances that a network can learn: appearance is a smoothed sum over the phones around a frame."""

import numpy as np

PHONES = ("sil", "a", "b", "c", "d", "e")


def utterances(number, seed=0, outputs=4, frames=(12, 30), noise=0.1):
    table = np.random.default_rng(99).normal(size=(len(PHONES), outputs))
    generator = np.random.default_rng(seed)
    result = []
    for _ in range(number):
        length = int(generator.integers(*frames))
        phones = generator.integers(0, len(PHONES), length // 6 + 2)
        triphones = np.stack([np.r_[0, phones[:-1]], phones, np.r_[phones[1:], 0]], axis=1)
        states = np.tile(np.repeat([0, 1, 2], 2), len(phones))
        labels = np.column_stack([np.repeat(triphones, 6, axis=0), states])[:length].astype(np.int16)
        values = table[labels[:, 1]] + 0.5 * table[labels[:, 0]] + 0.5 * table[labels[:, 2]]
        values = 10 * (values + noise * generator.normal(size=values.shape)) + 3
        result.append((labels, values.astype(np.float32)))
    return result
