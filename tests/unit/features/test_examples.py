import numpy as np
import pytest

from visualspeech.errors import DataError, StorageError
from visualspeech.features.examples import Examples, opened_blocks, streams_of
from visualspeech.features.streams import Stream
from visualspeech.storage.arrays import ArrayCollection, ArrayWriter


def write(path, utterances, arrays):
    """Arrays of every utterance: ``arrays`` gives them from the number that an utterance has."""
    with ArrayWriter(path) as out:
        for name, number in utterances.items():
            out.add(name, arrays(number), rate=25.0)
    return path


def labels(frames):
    return Stream(index=np.full((frames, 4), frames, np.int16)).arrays()


def dense(frames):
    return Stream(values=np.full((frames, 2), frames, np.float32)).arrays()


def targets(frames):
    return {"appearance": np.full((frames, 3), frames, np.float32), "points": np.zeros((frames, 2))}


@pytest.fixture
def files(tmp_path):
    shards = ({"a": 5, "c": 7}, {"b": 6})
    made = {"labels": labels, "dense": dense, "targets": targets}
    return {
        name: [write(tmp_path / name / f"{n}.h5", shard, arrays) for n, shard in enumerate(shards)]
        for name, arrays in made.items()
    }


@pytest.mark.parametrize("cache_bytes", [0, 150, 1e6])
def test_utterances_in_the_given_order_whatever_is_kept_in_memory(files, cache_bytes):
    with opened_blocks([*files["labels"], *files["dense"]], 2) as blocks, ArrayCollection(files["targets"]) as read:
        examples = Examples(blocks, read, ["c", "b", "a"], cache_bytes)
        for _ in range(2):
            assert [len(one.target) for one in (examples[n] for n in range(len(examples)))] == [7, 6, 5]
        (first, second), target, rate = examples[0]
        assert (first.index == 7).all() and first.values is None and first.starts is None
        assert (second.values == 7).all() and second.index is None
        assert target.shape == (7, 3) and rate == 25.0


def test_what_is_kept_is_bounded(files):
    with opened_blocks(files["labels"], 1) as blocks, ArrayCollection(files["targets"]) as read:
        # Of int16 labels (T, 4) and float32 targets (T, 3): 20 bytes a frame.
        examples = Examples(blocks, read, ["a", "b", "c"], cache_bytes=5 * 20 + 7 * 20)
        kept = [examples[number] is examples[number] for number in range(3)]
    assert kept == [True, True, False]


def test_no_block_at_all(files):
    with opened_blocks([], 0) as blocks, ArrayCollection(files["targets"]) as read:
        assert blocks == () and Examples(blocks, read, ["a"])[0].streams == ()


def test_streams_of_different_length_are_named(tmp_path, files):
    short = write(tmp_path / "short.h5", {"a": 4}, dense)
    with opened_blocks([files["labels"][0], short], 2) as blocks, ArrayCollection(files["targets"]) as read:
        with pytest.raises(DataError, match="a has 4 frames of features and 5 frames of targets"):
            Examples(blocks, read, ["a"])[0]


def test_segments_may_be_fewer_than_frames(tmp_path):
    path = write(tmp_path / "0.h5", {"a": 2}, lambda n: {"index": np.zeros((n, 3), np.int16), "starts": np.zeros(n)})
    with opened_blocks([path], 1) as blocks:
        (stream,) = streams_of("a", blocks, 40)
        assert len(stream) == 2 and stream.starts is not None


def test_an_utterance_that_no_shard_holds_is_named(files):
    with opened_blocks(files["labels"], 1) as blocks, pytest.raises(StorageError, match="no utterance 'x'"):
        streams_of("x", blocks, 4)
