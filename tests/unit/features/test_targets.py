"""Visual streams at the rate of a system."""

import numpy as np
import pytest

from visualspeech.features.resampling import resample
from visualspeech.features.targets import target_streams

VISUAL = {"appearance": np.random.default_rng(0).normal(size=(50, 3)).astype(np.float32), "points": np.zeros((50, 4))}


@pytest.mark.parametrize(("setting", "rate", "frames"), [(0, 50, 50), (25, 25, 25), (100, 100, 100)])
def test_every_stream_has_the_same_length(setting, rate, frames):
    streams, found = target_streams(VISUAL, 50.0, setting)
    assert found == rate and {len(values) for values in streams.values()} == {frames}
    assert np.array_equal(streams["appearance"], resample(VISUAL["appearance"], 50.0, rate))
    assert streams["appearance"].dtype == np.float32 and list(streams) == ["appearance", "points"]


def test_the_own_rate_changes_nothing():
    streams, rate = target_streams(VISUAL, 29.97, 0)
    assert rate == 29.97 and np.array_equal(streams["appearance"], VISUAL["appearance"])
