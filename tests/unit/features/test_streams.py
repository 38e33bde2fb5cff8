"""Labels and visual streams at one rate."""

import numpy as np
import pytest

from visualspeech.errors import SettingError
from visualspeech.features.streams import FeatureSettings, feature_streams
from visualspeech.speech.spoken import timed

ALIGNMENT = timed([("sil", 0.0, 0.4), ("aa", 0.4, 1.0)])


@pytest.mark.parametrize(("setting", "rate", "frames"), [(0, 50, 50), (25, 25, 25), (100, 100, 100)])
def test_every_stream_has_the_same_length(setting, rate, frames):
    visual = {"appearance": np.random.default_rng(0).normal(size=(50, 3)), "points": np.zeros((50, 4))}
    streams, found = feature_streams(ALIGNMENT, visual, 50.0, ["sil", "aa"], FeatureSettings(setting))
    assert found == rate
    assert {len(values) for values in streams.values()} == {frames}
    # The frames whose time lies in the second phone.
    times = (np.arange(frames) + 0.5) / rate
    assert np.array_equal(streams["labels"][:, 1] == 1, times >= 0.4)


def test_a_negative_rate_is_refused():
    with pytest.raises(SettingError, match=r"features\.rate"):
        FeatureSettings(-1)
