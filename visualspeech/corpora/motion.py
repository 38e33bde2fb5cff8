"""Motion capture of an utterance on a regular grid, without gaps: what a visual coding of markers reads.

Frame i at rate r holds the row that lies i / r after the first one and stands, as everywhere, for (i + 0.5) / r of the
sound: the first row is the first frame.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from visualspeech.corpora.motion_files import Recorded, read_csv, read_iemocap
from visualspeech.corpora.motion_settings import MotionSettings
from visualspeech.corpora.records import Utterance
from visualspeech.errors import RejectedUtterance
from visualspeech.timing import frames_in

STAGE = "motion"
#: Unit of the coordinates, by format; of other files it is not known.
UNITS = {"iemocap": "mm"}
MAX_RATE = 1000.0  # Hz
LARGEST = 1e9  # of a coordinate; beyond it a file is damaged, and float32 soon overflows
#: A measured rate this near to a whole number, as a share, is that number: times are rounded in files.
_SNAP = 5e-4


@dataclass(frozen=True)
class MotionSource:
    """How the motion capture of a corpus is read.

    Parameters
    ----------
    names : wanted markers or channels, in the order of the points
    format : ``iemocap`` or ``csv``
    rate : frames per second of the result; 0: as measured from the times of the rows
    timecode_rate : frames that a timecode counts in a second; 0: the usual rate that fits
    """

    names: tuple[str, ...]
    format: str = "csv"
    rate: float = 0.0
    timecode_rate: float = 0.0


@dataclass(frozen=True)
class Motion:
    """Motion capture on a regular grid.

    Parameters
    ----------
    points : (T, P, d) float32, without gaps
    rate : frames per second
    notes : what was found and does not prevent its use, for a warning
    """

    points: np.ndarray
    rate: float
    notes: tuple[str, ...] = ()


def read_motion(utterance: Utterance, source: MotionSource, seconds: float, settings: MotionSettings) -> Motion:
    """Read the motion capture of an utterance.

    Parameters
    ----------
    source : wanted markers, format and rates
    seconds : duration of the utterance's sound

    Raises
    ------
    RejectedUtterance
        The file cannot be read (see :mod:`visualspeech.corpora.motion_files`), a marker is never visible or occluded
        for too long, or the utterance is too short, or of another length than its sound.
    """
    if source.format == "iemocap":
        recorded = read_iemocap(utterance.motion, source.names)
    else:
        recorded = read_csv(utterance.motion, source.names, source.rate, source.timecode_rate)
    recorded = cut(recorded, utterance.start, utterance.end)
    return regular_motion(recorded, source.names, seconds, settings, source.rate)


def screen_dimensions(motion, ids: Sequence[str]) -> dict[str, RejectedUtterance]:
    """Rejections of utterances whose points have another number of dimensions than most, by utterance id.

    A corpus is of markers or of channels; one file may hold both under the same names.

    Parameters
    ----------
    motion : opened files of all utterances
    """
    dimensions = {one: motion.array(one, "points", slice(0, 1)).shape[2] for one in ids}
    counts = Counter(dimensions.values())
    usual = max(counts, key=lambda one: (counts[one], one), default=0)
    return {
        one: RejectedUtterance(
            f"its columns give {own} value{'s' * (own > 1)} per name, those of most utterances {usual}",
            "Export all motion capture with the same columns.",
        )
        for one, own in dimensions.items()
        if own != usual
    }


def cut(recorded: Recorded, start: float, end: float) -> Recorded:
    """The rows from ``start`` to before ``end`` seconds, times from the first of them; an ``end`` of 0 means to the
    last row.

    Raises
    ------
    RejectedUtterance
        There are none.
    """
    if not start and not end:
        return recorded
    inside = (recorded.times >= start - 1e-6) & (recorded.times < (end or np.inf) - 1e-6)
    if not inside.any():
        raise RejectedUtterance(
            f"no motion capture between {start:.2f} s and {f'{end:.2f} s' if end else 'the end'}",
            "Correct start and end in the corpus's table (in seconds).",
        )
    times = recorded.times[inside]
    return Recorded(times - times[0], recorded.points[inside])


def regular_motion(
    recorded: Recorded, names: Sequence[str], seconds: float, settings: MotionSettings, rate: float = 0.0
) -> Motion:
    """Motion capture with its gaps filled, on a regular grid.

    Gaps are filled linearly between the visible neighbours; a gap at the beginning or end keeps the nearest visible
    value. Rows whose times lie on the grid are taken as they are, others are interpolated linearly.

    Parameters
    ----------
    recorded : rows as a file holds them
    names : of the markers, for messages
    seconds : duration of the sound
    rate : of the grid, in Hz; 0: the measured one

    Raises
    ------
    RejectedUtterance
        As :func:`read_motion`.
    """
    rows = len(recorded.times)
    if rows < 3:
        raise RejectedUtterance(
            f"only {rows} frame{'s' * (rows > 1)} of motion capture", "Record again, or leave the utterance out."
        )
    measured = measured_rate(recorded.times)
    rate = rate or measured
    if not settings.min_rate <= rate <= MAX_RATE:
        raise RejectedUtterance(
            f"motion capture at {measured:.4g} frames per second",
            f"Record at {settings.min_rate:g} to {MAX_RATE:g} frames per second; times are in seconds.",
        )
    length = float(recorded.times[-1]) + 1 / measured
    _check_length(length, seconds, settings)
    _check_pauses(recorded.times, measured, settings.max_gap)
    points = filled(recorded, names, measured, settings.max_gap)
    frames = max(1, frames_in(length, rate))
    grid = np.arange(frames) / rate
    offset = float(np.abs(recorded.times - grid).max()) if frames == rows else np.inf
    notes: tuple[str, ...] = ()
    if offset * rate > settings.jitter_tolerance:
        points = _interpolated(grid, recorded.times, points)
        steps = np.diff(recorded.times)
        if np.abs(steps * measured - 1).max() > settings.jitter_tolerance:
            notes = (f"uneven times: rows are {steps.min() * 1000:.1f} to {steps.max() * 1000:.1f} ms apart at "
                     f"{measured:.4g} frames per second on average; the motion capture is resampled",)  # fmt: skip
    return Motion(points.astype(np.float32), rate, notes)


def measured_rate(times: np.ndarray) -> float:
    """Frames per second of at least two rows: the slope of row numbers over time, where missing rows count as rows.

    A rate that is nearly a whole number is that number.
    """
    steps = np.diff(times)
    # A step of nearly two rows has lost one; a shorter one is jitter.
    numbers = np.concatenate([[0], np.cumsum(np.maximum(np.floor(steps / np.median(steps) + 0.1), 1))])
    deviation = times - times.mean()
    slope = float(deviation @ (numbers - numbers.mean()) / (deviation @ deviation))
    whole = max(1.0, round(slope))
    return whole if abs(slope / whole - 1) <= _SNAP else slope


def filled(recorded: Recorded, names: Sequence[str], rate: float, longest: float) -> np.ndarray:
    """The points with all gaps of at most ``longest`` seconds interpolated, shape (T, P, d).

    A marker is occluded where any of its coordinates is missing. A gap lasts for its rows, each 1 / rate.

    Raises
    ------
    RejectedUtterance
        A marker is never visible, a gap is longer, or a value is beyond all measure.
    """
    times, points = recorded.times, recorded.points.copy()
    visible = np.isfinite(points).all(axis=2)
    never = [name for name, seen in zip(names, visible.any(axis=0), strict=True) if not seen]
    if never:
        raise RejectedUtterance(
            f"{'markers are' if len(never) > 1 else 'a marker is'} never visible: {', '.join(never[:6])}"
            f"{', ...' if len(never) > 6 else ''}",
            "Leave the utterance out, or leave the marker out of the corpus's `regions`.",
        )
    for marker in np.flatnonzero(~visible.all(axis=0)):
        seen = visible[:, marker]
        begin, rows = longest_gap(seen)
        if rows / rate > longest + 1e-9:
            raise RejectedUtterance(
                f"the marker {names[marker]} is occluded for {rows / rate:.2f} s from {times[begin]:.2f} s on, longer "
                f"than `motion.max_gap: {longest:g}`",
                "Leave the utterance out, or raise the setting to have longer gaps interpolated.",
            )
        points[:, marker] = _interpolated(times, times[seen], points[seen, marker])
    if np.abs(points).max() > LARGEST:
        raise RejectedUtterance(
            f"the motion capture holds values beyond {LARGEST:g}", "Export the motion capture again."
        )
    return points


def longest_gap(seen: np.ndarray) -> tuple[int, int]:
    """First row and number of rows of the longest run of False; (0, 0) if there is none."""
    borders = np.flatnonzero(np.diff(np.concatenate([[True], seen, [True]]).astype(np.int8)))
    starts, ends = borders[::2], borders[1::2]
    if not len(starts):
        return 0, 0
    longest = int(np.argmax(ends - starts))
    return int(starts[longest]), int(ends[longest] - starts[longest])


def _interpolated(wanted: np.ndarray, times: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values, (T, ...), at the wanted times, linear in between and constant beyond the ends."""
    flat = values.reshape(len(times), -1)
    columns = [np.interp(wanted, times, flat[:, column]) for column in range(flat.shape[1])]
    return np.stack(columns, axis=1).reshape(len(wanted), *values.shape[1:])


def _check_length(length: float, seconds: float, settings: MotionSettings) -> None:
    if length < settings.min_seconds:
        raise RejectedUtterance(f"only {length:.2f} s of motion capture", "Record again, or leave the utterance out.")
    if abs(length - seconds) > settings.max_length_difference:
        raise RejectedUtterance(
            f"sound and motion capture differ in length: {seconds:.2f} s of sound, {length:.2f} s of motion capture",
            "Check that both files are of one recording, begin together and are complete; correct start and end.",
        )


def _check_pauses(times: np.ndarray, rate: float, longest: float) -> None:
    steps = np.diff(times)
    widest = int(steps.argmax())
    if steps[widest] - 1 / rate > longest:
        raise RejectedUtterance(
            f"no rows between {times[widest]:.2f} s and {times[widest + 1]:.2f} s, a pause longer than "
            f"`motion.max_gap: {longest:g}`",
            "Export the motion capture again, or raise the setting to have longer pauses interpolated.",
        )
