"""A pair: two pictures of one height beside each other with sound, and no word of the models."""

import av
import numpy as np

from tests.unit.animation.test_video import spoken  # noqa: F401
from visualspeech.animation.pairs import write_pair
from visualspeech.media.reading import probe, read_frames


def test_a_pair_shows_both_and_names_neither(spoken, tmp_path):  # noqa: F811
    utterance, recording, speaker, v = spoken
    open_mouth = v + np.float32(3) * v.std(axis=0)
    path = tmp_path / "01.mp4"
    write_pair(path, 1, utterance, recording, [(v, 25.0), (open_mouth, 25.0)], speaker, "made up", "It is nobody.")
    frames = list(read_frames(path))
    width = frames[0].shape[1] // 2
    assert len(frames) == 20 and width == 360 and probe(path).audio_rate == 48000
    below = [np.abs(frame[60:, :width].astype(int) - frame[60:, width:]).mean() for frame in frames]
    assert min(below) > 0.2
    with av.open(str(path)) as file:
        said = dict(file.metadata)
    assert "Pair 1" in said["title"] and "SYNTHETIC" in said["comment"] and "It is nobody" in said["comment"]
    assert "FBB" not in str(said) and said["model"] == "withheld for a preference test"
