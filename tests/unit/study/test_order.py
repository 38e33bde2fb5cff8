"""Orders and sides are random and balanced over participants."""

from collections import Counter
from dataclasses import replace

import pytest

from visualspeech.study.layouts import ATTENTION, ITEM, PRACTICE, PREFERENCE
from visualspeech.study.order import presentations
from visualspeech.study.records import Item, Question, Study

COUNT = 6


def study(attention=2, stimuli=("l.mp4", "r.mp4")):
    items = [Item(f"i{number}", ITEM, stimuli, 1.0) for number in range(COUNT)]
    items += [Item("p", PRACTICE, stimuli, 1.0)]
    items += [Item(f"t{number}", ATTENTION, stimuli[:1], 1.0) for number in range(attention)]
    return Study("s", PREFERENCE, "t", "", "", (Question("q", "?", ("left", "right")),), tuple(items), None, "0" * 12)


def main_items(steps):
    return [one for one in steps if one.item.startswith("i")]


def test_every_item_is_at_every_position_once_in_a_block_of_participants():
    orders = [[one.item for one in main_items(presentations(study(), number))] for number in range(2 * COUNT)]
    assert all(sorted(order) == sorted(orders[0]) for order in orders)
    for block in (orders[:COUNT], orders[COUNT:]):
        assert all(len(set(column)) == COUNT for column in zip(*block, strict=True))
    assert len({tuple(order) for order in orders}) > COUNT
    # Not one rotated order: items have different neighbours.
    neighbours = {pair for order in orders for pair in zip(order, order[1:], strict=False)}
    assert len(neighbours) > 2 * COUNT


def test_sides_are_balanced_within_and_between_participants():
    steps = [main_items(presentations(study(), number)) for number in range(20)]
    assert all(sum(one.mirrored for one in own) == COUNT // 2 for own in steps)
    for first, second in zip(steps[::2], steps[1::2], strict=True):
        sides = dict(first)
        assert all(sides[item] != mirrored for item, mirrored in second)
    shown = Counter(one for own in steps for one in own)
    assert set(shown.values()) == {10}


def test_one_stimulus_is_never_mirrored():
    assert not any(one.mirrored for one in presentations(study(stimuli=("l.mp4",)), 1))


def test_practice_is_first_and_attention_items_lie_apart():
    for number in range(5):
        steps = [one.item for one in presentations(study(), number)]
        assert steps[0] == "p" and sorted(steps) == sorted(one.id for one in study().items)
        assert [index for index, item in enumerate(steps) if item.startswith("t")] == [3, 6]


@pytest.mark.parametrize("attention", [0, 1, 5])
def test_a_participant_sees_the_same_again(attention):
    one = study(attention)
    assert presentations(one, 7) == presentations(one, 7)
    assert presentations(one, 7) != presentations(replace(one, digest="1" * 12), 7)
