"""Frame i at rate r stands for the time (i + 0.5) / r."""

import numpy as np
import pytest

from visualspeech import timing


def test_frame_times_are_the_middles():
    np.testing.assert_allclose(timing.frame_times(3, 25.0), [0.02, 0.06, 0.10])


@pytest.mark.parametrize("rate", [25.0, 30000 / 1001, 100.0, 120.0])
def test_frames_in_counts_the_frames_whose_time_lies_inside(rate):
    for seconds in np.random.default_rng(0).uniform(0, 5, 50):
        inside = (timing.frame_times(1000, rate) < seconds).sum()
        assert timing.frames_in(seconds, rate) == inside


def test_interval_of_frame_agrees_with_a_search_by_hand():
    starts = np.array([0.0, 0.5, 0.7])
    times = np.array([-0.1, 0.0, 0.49, 0.5, 0.69, 0.7, 9.0])
    by_hand = [max([index for index, start in enumerate(starts) if start <= time], default=0) for time in times]
    np.testing.assert_array_equal(timing.interval_of_frame(starts, times), by_hand)
