"""Streams: what they hold, what does not fit a layout, and several side by side."""

import numpy as np
import pytest

from visualspeech.errors import DataError
from visualspeech.features.streams import Layout, Stream, check_stream, joined

BOTH = Layout(sizes=(3, 2), dimension=2)


def stream(frames=4, **change):
    parts = {"index": np.ones((frames, 2), np.int16), "values": np.zeros((frames, 2), np.float32)}
    return Stream(**{**parts, **change})


def test_length_arrays_and_width():
    assert len(stream(5)) == len(Stream(values=np.zeros((5, 1)))) == 5
    assert list(stream().arrays()) == ["index", "values"]
    assert list(Stream(index=np.zeros((1, 1), int), starts=np.zeros(1)).arrays()) == ["index", "starts"]
    assert (BOTH.width, Layout().width, Layout(dimension=3).width) == (7, 0, 3)
    # What is stored is what a stream is made of.
    assert np.array_equal(Stream(**stream().arrays()).values, stream().values)


def test_streams_that_fit():
    check_stream(stream(), BOTH, "both")
    check_stream(Stream(values=np.zeros((1, 2))), Layout(dimension=2), "dense")
    check_stream(Stream(index=np.array([[2], [0]]), starts=np.zeros(2)), Layout(sizes=(3,), segmental=True), "segments")


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (stream(index=None), "has 0 categorical and 2 real-valued columns, the model reads 2 and 2"),
        (stream(values=None), "has 2 categorical and 0 real-valued columns"),
        (stream(values=np.zeros((4, 3))), "has 2 categorical and 3 real-valued columns"),
        (stream(starts=np.zeros(4)), "the rows of a stream are segments, the model reads frames"),
        (stream(0), "a stream has no frame"),
        (stream(index=np.array([[0, 2]] * 4)), r"a class is outside its inventory \(3, 2 classes\)"),
        (stream(index=np.array([[-1, 0]] * 4)), "a class is outside its inventory"),
        (stream(values=np.array([[0, np.nan]] * 4)), "a value is not a finite number"),
        (stream(values=np.array([[np.inf, 0]] * 4)), "a value is not a finite number"),
        (stream(values=np.zeros((5, 2))), r"the arrays of a stream differ in length \(index 4, values 5\)"),
        (stream(index=np.zeros((5, 2), int)), r"differ in length \(index 5, values 4\)"),
    ],
)
def test_streams_that_do_not_fit_name_the_block(given, said):
    with pytest.raises(DataError, match=f"input block `both`: .*{said}"):
        check_stream(given, BOTH, "both")


def test_segments_that_do_not_fit():
    layout = Layout(sizes=(3,), segmental=True)
    with pytest.raises(DataError, match="the rows of a stream are frames, the model reads segments"):
        check_stream(Stream(index=np.zeros((2, 1), int)), layout, "track")
    with pytest.raises(DataError, match=r"differ in length \(index 2, starts 3\)"):
        check_stream(Stream(index=np.zeros((2, 1), int), starts=np.zeros(3)), layout, "track")


def test_columns_side_by_side():
    classes, values = joined([stream(), Stream(index=np.full((4, 1), 2, np.uint8)), Stream(values=np.ones((4, 3)))])
    assert classes.tolist() == [[1, 1, 2]] * 4 and classes.dtype == np.int64
    assert values.tolist() == [[0, 0, 1, 1, 1]] * 4 and values.dtype == np.float32
    classes, values = joined([Stream(values=np.ones((3, 2)))])
    assert classes.shape == (3, 0) and values.shape == (3, 2)
    assert joined([Stream(index=np.ones((3, 2), int))])[1].shape == (3, 0)
