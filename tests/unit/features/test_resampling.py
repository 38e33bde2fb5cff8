import numpy as np
import pytest

from visualspeech.errors import DataError
from visualspeech.features.resampling import at_times, back_from_means, back_from_times, resample
from visualspeech.timing import frame_times


@pytest.mark.parametrize("rate", [10.0, 12.5, 24.0, 29.97, 50.0, 100.0])
def test_a_ramp_stays_the_same_ramp_away_from_the_ends(rate):
    values = 3 * frame_times(75, 25.0)[:, None] + np.array([1.0, -2.0])
    result = resample(values, 25.0, rate)
    times = frame_times(len(result), rate)
    inside = (times > 0.1) & (times < 2.9)
    expected = 3 * times[:, None] + np.array([1.0, -2.0])
    assert np.allclose(result[inside], expected[inside], atol=1e-9)


def test_length_and_constant():
    result = resample(np.full((75, 2), 4.0, np.float32), 25.0, 120.0)
    assert result.shape == (360, 2) and result.dtype == np.float32
    assert np.allclose(result, 4.0)
    assert resample(np.ones((1, 2)), 25.0, 1.0).shape == (1, 2)
    assert resample(np.ones(10), 100.0, 25.0, frames=2).shape == (2,)


def test_the_same_rate_changes_nothing():
    values = np.random.default_rng(1).normal(size=(9, 3))
    result = resample(values, 25.0, 25.0)
    assert np.array_equal(result, values) and result is not values


def test_up_and_down_by_a_whole_factor_in_closed_form():
    # Twice the rate: a quarter of the way to each neighbour.
    assert np.allclose(resample(np.array([0.0, 4.0]), 10.0, 20.0), [0, 1, 3, 4])
    # Half the rate: the frame's two centres lie 1/4 and 3/4 into it; between two frames the line goes on.
    # Mean over [0, 0.2] of the line through (0.05, 0), (0.15, 4), (0.25, 8), (0.35, 8), constant outside.
    first = (0.1 * (0 + 4) / 2 + 0.05 * (4 + 6) / 2) / 0.2
    second = (0.05 * (6 + 8) / 2 + 0.1 * 8 + 0.05 * 8) / 0.2
    assert np.allclose(resample(np.array([0.0, 4.0, 8.0, 8.0]), 10.0, 5.0), [first, second])


def test_the_mean_over_frames_against_fine_sampling():
    values = np.random.default_rng(2).normal(size=(60, 2))
    result = resample(values, 100.0, 29.0)
    fine = (np.arange(200_000) + 0.5) / 200_000 * len(result) / 29.0
    line = np.stack([np.interp(fine, frame_times(60, 100.0), column) for column in values.T], axis=1)
    frame = (fine * 29.0).astype(int)
    expected = np.stack([line[frame == number].mean(axis=0) for number in range(len(result))])
    assert np.allclose(result, expected, atol=1e-3)


def test_what_is_too_fast_for_the_new_rate_does_not_fold_back():
    times = frame_times(400, 100.0)
    fast = np.sin(2 * np.pi * 24.0 * times)
    assert np.abs(fast[2::4]).max() > 0.9
    assert np.abs(resample(fast, 100.0, 25.0)).max() < 0.15


def test_nothing_to_resample():
    with pytest.raises(DataError):
        resample(np.zeros((0, 2)), 25.0, 50.0)
    with pytest.raises(DataError):
        resample(np.zeros((3, 2)), 25.0, 0.0)


@pytest.mark.parametrize(("rate_in", "rate_out"), [(100.0, 25.0), (25.0, 29.97), (25.0, 25.0), (120.0, 29.97)])
def test_a_part_is_that_of_the_whole(rate_in, rate_out):
    values = np.random.default_rng(3).normal(size=(200, 2)).cumsum(axis=0)
    whole = resample(values, rate_in, rate_out)
    first, last = len(whole) // 3, len(whole) // 2
    begin = int(first / rate_out * rate_in) - 2
    end = int(last / rate_out * rate_in) + 3
    part = resample(values[begin:end], rate_in, rate_out, last - first, begin=first / rate_out - begin / rate_in)
    assert np.allclose(part, whole[first:last])


@pytest.mark.parametrize("frames", [1, 2, 30])
def test_reading_at_times_and_its_transpose(frames):
    generator = np.random.default_rng(4)
    values, times = generator.normal(size=(frames, 3)), generator.uniform(-0.1, 0.4, 50)
    expected = np.stack([np.interp(times, frame_times(frames, 100.0), column) for column in values.T], axis=1)
    read = at_times(values, 100.0, times)
    assert np.allclose(read, expected)
    errors = generator.normal(size=read.shape)
    back = back_from_times(errors, frames, 100.0, times)
    assert back.shape == values.shape and np.isclose((errors * read).sum(), (back * values).sum())


@pytest.mark.parametrize(
    ("rate_in", "rate_out", "frames"), [(100.0, 25.0, 17), (100.0, 29.97, 9), (75.0, 25.0, 1), (20.0, 25.0, 17)]
)
def test_the_transpose_of_resampling_against_its_columns(rate_in, rate_out, frames):
    length = int(frames / rate_out * rate_in)
    columns = resample(np.eye(length), rate_in, rate_out, frames)
    errors = np.random.default_rng(5).normal(size=(frames, 3))
    assert np.allclose(back_from_means(errors, length, rate_in, rate_out), columns.T @ errors)
