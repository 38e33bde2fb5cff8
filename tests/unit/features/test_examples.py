import numpy as np
import pytest

from visualspeech.errors import DataError
from visualspeech.features.examples import Examples
from visualspeech.storage import ArrayCollection, ArrayWriter


def write(path, lengths):
    with ArrayWriter(path) as out:
        for name, (labels, frames) in lengths.items():
            arrays = {"labels": np.zeros((labels, 4), np.int16), "appearance": np.full((frames, 3), frames, np.float32)}
            out.add(name, arrays, rate=25.0)


@pytest.mark.parametrize("cache_bytes", [0, 150, 1e6])
def test_utterances_in_the_given_order_whatever_is_kept_in_memory(tmp_path, cache_bytes):
    write(tmp_path / "0.h5", {"a": (5, 5), "c": (7, 7)})
    write(tmp_path / "1.h5", {"b": (6, 6)})
    with ArrayCollection([tmp_path / "0.h5", tmp_path / "1.h5"]) as features:
        examples = Examples(features, ["c", "b", "a"], cache_bytes)
        for _ in range(2):
            assert [len(values) for _, values in (examples[n] for n in range(len(examples)))] == [7, 6, 5]


def test_streams_of_different_length_are_named(tmp_path):
    write(tmp_path / "0.h5", {"a": (5, 6)})
    with ArrayCollection([tmp_path / "0.h5"]) as features, pytest.raises(DataError, match="a has 5 .* 6"):
        Examples(features, ["a"])[0]
