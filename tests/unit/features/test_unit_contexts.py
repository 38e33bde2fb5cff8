"""Frames in units: positions, counts and spans that can be counted by hand, against a slow plain version."""

import numpy as np
import pytest

from tests.unit.speech.alignments import even_alignment
from visualspeech.features.unit_contexts import NO_POSITION, POSITIONS, frames_in_units, neighbours, positions
from visualspeech.speech.alignment import starts_of


def test_frames_of_three_units():
    found = frames_in_units(np.array([0.0, 0.05, 0.06]), 10, 100.0)
    assert found.unit.tolist() == [0] * 5 + [1] + [2] * 4
    assert found.count.tolist() == [5] * 5 + [1] + [4] * 4
    assert found.span.tolist() == [5, 4, 3, 2, 1, 1, 4, 3, 2, 1]
    names = [POSITIONS[at] for at in found.position]
    assert names == ["start", "start", "middle", "end", "end", "middle", "start", "middle", "middle", "end"]


@pytest.mark.parametrize(
    ("count", "expected"),
    [
        (1, ["middle"]),
        (2, ["start", "end"]),
        (3, ["start", "middle", "end"]),
        (6, ["start"] * 2 + ["middle"] * 2 + ["end"] * 2),
    ],
)
def test_positions_are_thirds(count, expected):
    found = positions(np.arange(1, count + 1), np.full(count, count))
    assert [POSITIONS[at] for at in found] == expected and found.dtype == np.uint8
    # Seen from the end, the start is the end.
    assert (2 - found[::-1]).tolist() == found.tolist()


def test_what_belongs_to_no_unit_has_no_position():
    assert positions(np.zeros(2, int), np.zeros(2, int)).tolist() == [NO_POSITION] * 2


def test_random_units_against_a_count_frame_by_frame():
    random = np.random.default_rng(4)
    for _ in range(30):
        starts = np.r_[0.0, np.sort(random.uniform(0, 1, random.integers(1, 40)))]
        rate = float(random.choice([25, 50, 100, 29.97]))
        frames = int(rate)
        found = frames_in_units(starts, frames, rate)
        unit = [sum(start <= (i + 0.5) / rate for start in starts) - 1 for i in range(frames)]
        assert found.unit.tolist() == unit
        for i in range(frames):
            own = [j for j in range(frames) if unit[j] == unit[i]]
            at = own.index(i)
            assert (found.count[i], found.span[i]) == (len(own), len(own) - at)
            assert found.position[i] == int((at + 0.5) / len(own) * 3)


def test_times_in_seconds_are_the_same_at_any_rate():
    starts = starts_of(even_alignment([("word", "k ah m p y uw t er".split())]).phones)
    slow, fast = frames_in_units(starts, 40, 50.0), frames_in_units(starts, 160, 200.0)
    assert np.allclose(slow.count / 50.0, fast.count[::4] / 200.0)
    assert np.allclose(fast.count.reshape(40, 4) / 200.0, slow.count[:, None] / 50.0)


def test_five_units_around_each():
    labels = np.array([7, 8, 9], np.uint8)
    found = neighbours(labels, 0)
    assert found.tolist() == [[0, 0, 7, 8, 9], [0, 7, 8, 9, 0], [7, 8, 9, 0, 0]] and found.dtype == np.uint8
    assert neighbours(labels, 1, 1, 0).tolist() == [[1, 7], [7, 8], [8, 9]]
    assert neighbours(labels[:1], 0).tolist() == [[0, 0, 7, 0, 0]]
