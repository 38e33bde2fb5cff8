"""What each participant sees: a random order and sides of his or her own, balanced over participants."""

from typing import NamedTuple

import numpy as np

from visualspeech.study.layouts import ATTENTION, ITEM, PRACTICE
from visualspeech.study.records import Study


class Presentation(NamedTuple):
    """One step of a participation: the id of an item and the index of the stimulus that is shown."""

    item: str
    mirrored: int


def presentations(study: Study, number: int) -> tuple[Presentation, ...]:
    """All steps of the participation of one participant: practice first, attention items spread evenly.

    The orders of n items are rows of Latin squares whose rows, columns and items are permuted at random: n consecutive
    participants see every item once at every position. A participant sees half of the pairs mirrored (rounded), and
    the next one the other half.

    Parameters
    ----------
    number : of the participant, from 0 in the order in which they start
    """
    seed = int(study.digest, 16)
    items = sorted(study.of_role(ITEM), key=lambda one: one.id)
    count = len(items)
    block, row = divmod(number, count)
    generator = np.random.default_rng([seed, 0, block])
    rows, columns, symbols = (generator.permutation(count) for _ in range(3))
    order = [items[symbols[(rows[row] + column) % count]] for column in columns]
    generator = np.random.default_rng([seed, 1, number // 2])
    half = generator.permutation((np.arange(count) + generator.integers(2)) % 2) ^ (number % 2)
    sides = dict(zip((one.id for one in items), half.tolist(), strict=True))
    main = [Presentation(one.id, sides[one.id] if len(one.stimuli) == 2 else 0) for one in order]
    generator = np.random.default_rng([seed, 2, number])
    attention = generator.permutation(sorted(one.id for one in study.of_role(ATTENTION))).tolist()
    for index, item in reversed(list(enumerate(attention, 1))):
        main.insert(round(index * count / (len(attention) + 1)), Presentation(item, 0))
    practice = [Presentation(one.id, number % 2 * (len(one.stimuli) - 1)) for one in study.of_role(PRACTICE)]
    return (*practice, *main)
