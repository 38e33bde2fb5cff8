"""Streams of values brought to another frame rate, on the time grid of :mod:`visualspeech.timing`."""

import numpy as np

from visualspeech.errors import DataError
from visualspeech.timing import frame_times, frames_in


def resample(
    values: np.ndarray, rate_in: float, rate_out: float, frames: int | None = None, begin: float = 0.0
) -> np.ndarray:
    """Values of a stream at another frame rate.

    Frame i stands for the time (i + 0.5) / rate; between frame centres the stream is taken as linear, before the first
    and after the last as constant. A higher rate reads that line at the new frame centres. A lower rate takes the
    line's exact mean over each new frame, which keeps what changes faster than the new rate from folding back.

    Parameters
    ----------
    values : (T, ...) frames at ``rate_in`` Hz
    rate_in, rate_out : Hz
    frames : number of frames to return; default: those whose time lies inside T / rate_in seconds, at least one
    begin : seconds from the beginning of ``values`` to that of the first frame returned

    Returns
    -------
    (frames, ...) of the dtype of ``values`` (float64 where they are no floats); a copy of ``values`` where nothing
    changes.

    Raises
    ------
    DataError
        There is no frame, or a rate is not positive.
    """
    values = np.asarray(values)
    if not len(values) or not (rate_in > 0 and rate_out > 0):
        raise DataError(f"cannot resample {len(values)} frames from {rate_in} to {rate_out} Hz; both must be positive.")
    if frames is None:
        frames = max(frames_in(len(values) / rate_in - begin, rate_out), 1)
    if rate_in == rate_out and frames == len(values) and not begin:
        return values.copy()
    kind = values.dtype if np.issubdtype(values.dtype, np.floating) else np.float64
    flat = values.reshape(len(values), -1).astype(np.float64)
    centres = begin + frame_times(frames, rate_out)
    if rate_out >= rate_in:
        result = at_times(flat, rate_in, centres)
    else:
        edges = begin + np.arange(frames + 1) / rate_out
        result = np.diff(_integral(flat, rate_in, edges), axis=0) * rate_out
    return result.reshape(frames, *values.shape[1:]).astype(kind)


def at_times(values: np.ndarray, rate: float, times: np.ndarray) -> np.ndarray:
    """A stream (T, N) at ``rate`` Hz, taken as linear between its frame centres, at times in seconds (M,): (M, N)."""
    below, above, share = _taps(len(values), rate, times)
    return values[below] * (1 - share) + values[above] * share


def back_from_times(errors: np.ndarray, frames: int, rate: float, times: np.ndarray) -> np.ndarray:
    """The transpose of :func:`at_times`: the derivative (frames, N) of errors (M, N) by the stream that was read.

    Parameters
    ----------
    frames, rate : length and rate in Hz of the stream
    times : (M,) seconds at which it was read
    """
    below, above, share = _taps(frames, rate, times)
    result = np.zeros((frames, errors.shape[1]))
    np.add.at(result, below, (1 - share) * errors)
    np.add.at(result, above, share * errors)
    return result


def back_from_means(errors: np.ndarray, frames: int, rate: float, rate_out: float) -> np.ndarray:
    """The transpose of :func:`resample` to another rate: the derivative (frames, N) by the stream.

    Parameters
    ----------
    errors : (T, N) by the resampled stream
    frames, rate : length and rate in Hz of the stream that was resampled
    rate_out : rate of the resampled stream in Hz
    """
    if rate_out >= rate:
        return back_from_times(errors, frames, rate, frame_times(len(errors), rate_out))
    edges, knots = np.arange(len(errors) + 1) / rate_out, frame_times(frames, rate)
    cuts = np.unique(np.r_[edges, knots[knots < edges[-1]]])
    # Between cuts the stream is a line: the mean over a frame is a sum of trapezia, each half of either end.
    frame = np.searchsorted(edges, cuts[:-1], side="right") - 1
    halves = errors[frame] * (np.diff(cuts) * rate_out / 2)[:, None]
    at_cuts = np.pad(halves, ((0, 1), (0, 0))) + np.pad(halves, ((1, 0), (0, 0)))
    return back_from_times(at_cuts, frames, rate, cuts)


def _taps(frames: int, rate: float, times: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The frames before and after each time, and the share (M, 1) of the later one."""
    place = np.clip(times * rate - 0.5, 0, frames - 1)
    below = np.minimum(place.astype(int), max(frames - 2, 0))
    return below, np.minimum(below + 1, frames - 1), (place - below)[:, None]


def _integral(values: np.ndarray, rate: float, times: np.ndarray) -> np.ndarray:
    """Integral of the line from 0 to each time: trapezia between frame centres, constant pieces at both ends."""
    knots = np.r_[0.0, frame_times(len(values), rate)]
    heights = np.concatenate([values[:1], values])
    areas = np.diff(knots)[:, None] * (heights[1:] + heights[:-1]) / 2
    total = np.concatenate([np.zeros_like(values[:1]), np.cumsum(areas, axis=0)])
    piece = np.clip(np.searchsorted(knots, times, side="right") - 1, 0, len(knots) - 1)
    rest = (times - knots[piece])[:, None]
    # Past the last knot the line is constant, so the mean height of the piece is that of its start.
    return total[piece] + rest * (heights[piece] + at_times(values, rate, times)) / 2
