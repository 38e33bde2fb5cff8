"""Labels and visual streams at one rate."""

import numpy as np
import pandas
import pytest
from visualspeech.speech.rows import silent_frames

from visualspeech.errors import SettingError
from visualspeech.features.streams import FeatureSettings, feature_streams

ROWS = pandas.DataFrame(
    [("phone", 0, -1, "sil", 0.0, 0.4), ("phone", 1, -1, "aa", 0.4, 1.0)]
    + [("state", k, k // 3, str(k % 3 + 1), s, s + 0.1) for k, s in enumerate((0.0, 0.1, 0.2, 0.4, 0.6, 0.8))],
    columns=["tier", "index", "parent", "label", "start", "end"],
)


@pytest.mark.parametrize(("setting", "rate", "frames"), [(0, 50, 50), (25, 25, 25), (100, 100, 100)])
def test_every_stream_has_the_same_length(setting, rate, frames):
    visual = {"appearance": np.random.default_rng(0).normal(size=(50, 3)), "points": np.zeros((50, 4))}
    streams, found = feature_streams(ROWS, visual, 50.0, ["sil", "aa"], FeatureSettings(setting))
    assert found == rate
    assert {len(values) for values in streams.values()} == {frames}
    # The frames whose time lies in the second phone.
    times = (np.arange(frames) + 0.5) / rate
    assert np.array_equal(streams["labels"][:, 1] == 1, times >= 0.4)


def test_silent_frames_are_those_of_the_pause():
    assert silent_frames(ROWS, 10, 10.0).tolist() == [True] * 4 + [False] * 6


def test_a_negative_rate_is_refused():
    with pytest.raises(SettingError, match=r"features\.rate"):
        FeatureSettings(-1)
