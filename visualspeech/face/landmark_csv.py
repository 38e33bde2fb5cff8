"""Landmarks that another program has written: CSV files with the columns of OpenFace, one per recording.

OpenFace (Baltrusaitis et al., "OpenFace 2.0", FG 2018) writes one row per frame: ``frame`` (from 1), ``face_id``,
``timestamp`` (seconds, of frame 1: 0), ``confidence`` (0 to 1), ``success`` (0 or 1) and, among several hundred others,
``x_0`` to ``x_67`` and ``y_0`` to ``y_67``: the iBUG points in pixels. It writes a space after each comma.

A file may come from a stranger: it is read line by line, and only the columns that are needed are kept.
"""

import stat
from array import array
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

import numpy as np

from visualspeech.errors import RejectedUtterance
from visualspeech.face.landmark_paths import csv_candidates, csv_of
from visualspeech.face.tracker import POINTS, LandmarkSettings, TrackedVideo

POINT_COLUMNS = tuple(f"{axis}_{number}" for axis in "xy" for number in range(POINTS))
OPTIONAL = ("frame", "timestamp", "face_id", "confidence", "success")
MAX_LINE = 30_000  # characters; those of OpenFace have about 8,000
MAX_ROWS = 200_000  # two hours at 25 frames/s, of which 120 MB are kept
#: A face with a larger share of its points outside the frame than this is none of this video.
MAX_OUTSIDE = 1 / 3
CAUSES = ("not in the file", "marked as not tracked", "not numbers", "outside the frame")
AGAIN = "Run the landmark program on this recording again, or leave the recording out."


class CsvLandmarks:
    """Gives the landmarks of a file as a tracker does; see :class:`visualspeech.face.tracker.Tracker`.

    Raises
    ------
    RejectedUtterance
        There is no file for the recording, or it cannot be read.
    """

    remedy = AGAIN  # where too many frames have no face

    def __init__(self, settings: LandmarkSettings, video: TrackedVideo) -> None:
        found = csv_of(settings.folder, video.path)
        if found is None:
            name = csv_candidates(settings.folder, video.path)[-1]
            raise RejectedUtterance(
                f"no landmark file {name}", "Write the landmarks of this recording to that file, or leave it out."
            )
        self._name = found.name
        table = read_landmarks(found)
        at = np.where(np.isfinite(table["frame"]), table["frame"], table["timestamp"])
        self._faces = int(np.unique(at, return_counts=True)[1].max())
        face = _main_face(table)
        self._points = face["points"]
        self._usable = (face["success"] > 0) & (face["confidence"] >= settings.min_confidence)
        self._rows, self._warnings = rows_of_frames(face["frame"], face["timestamp"], video.rate)
        self._causes = dict.fromkeys(CAUSES, 0)

    def next(self, frame: np.ndarray, number: int) -> np.ndarray | None:
        row = self._rows.get(number, -1)
        points = self._points[row] if row >= 0 else None
        cause = self._cause(row, points, frame.shape[1::-1])
        if cause:
            self._causes[cause] += 1
            return None
        return points

    def faces(self) -> int:
        return self._faces

    def warnings(self) -> list[str]:
        causes = ", ".join(f"{count} {cause}" for cause, count in self._causes.items() if count)
        return [*self._warnings, *([f"landmarks of {self._name}, frames without a face: {causes}"] if causes else [])]

    def _cause(self, row: int, points: np.ndarray | None, size: tuple[int, int]) -> str:
        """Why the frame counts as one without a face; empty if it does not."""
        if points is None:
            return "not in the file"
        if not self._usable[row]:
            return "marked as not tracked"
        if not np.isfinite(points).all():
            return "not numbers"
        outside = ((points < 0) | (points > np.array(size))).any(axis=1)
        return "outside the frame" if outside.mean() > MAX_OUTSIDE else ""


def rows_of_frames(frame: np.ndarray, timestamp: np.ndarray, rate: float) -> tuple[dict[int, int], list[str]]:
    """Which row shows which frame of the video.

    Times decide where the file has them and they ascend: frame i of the video begins at i / ``rate`` seconds, and the
    row nearest to that, at most half a frame away, is its row. Otherwise the frame numbers decide.

    Parameters
    ----------
    frame : (n,) frame numbers from 1; NaN where the file has none
    timestamp : (n,) seconds from the first frame; NaN where the file has none
    rate : frame rate of the video in Hz

    Returns
    -------
    Frame of the video (from 0) -> row, and warnings
    """
    timed = np.isfinite(timestamp).all() and len(timestamp) > 0 and (np.diff(timestamp) > 0).all()
    numbered = np.isfinite(frame).all() and len(frame) > 0 and (timed or (np.diff(frame) > 0).all())
    if not timed:
        if not numbered:
            raise RejectedUtterance("the landmark file has neither ascending times nor ascending frame numbers", AGAIN)
        return {int(number) - 1: row for row, number in enumerate(frame)}, []
    at = timestamp * rate
    nearest: dict[int, int] = {}
    for row in np.argsort(np.abs(at - np.rint(at)), kind="stable"):
        nearest.setdefault(int(np.rint(at[row])), int(row))
    warnings = []
    if numbered and np.abs(at - (frame - 1)).max() > 0.5:
        worst = int(np.abs(at - (frame - 1)).argmax())
        warnings.append(
            f"the landmark file numbers the frame at {timestamp[worst]:g} s {frame[worst]:g}, the video at {rate:g} Hz "
            f"{at[worst] + 1:.0f}; the times were used"
        )
    return nearest, warnings


def read_landmarks(path: Path) -> dict[str, np.ndarray]:
    """The columns of a landmark file.

    Returns
    -------
    ``points`` (n, 68, 2) float32 in pixels; ``frame``, ``timestamp``, ``face_id``, ``confidence`` and ``success`` (n,),
    with NaN for a missing frame or timestamp, 0 for a missing face_id and 1 for a missing confidence or success

    Raises
    ------
    RejectedUtterance
        It is no file that can be read, has no such columns, rows of different lengths, a value that is no number, or
        too many or too long rows.
    """
    try:
        state = path.stat()
        if not stat.S_ISREG(state.st_mode):
            raise RejectedUtterance(f"the landmark file {path} is not a regular file", AGAIN)
        return _read(path, state.st_size, state.st_mtime_ns)
    except OSError as error:
        raise RejectedUtterance(f"the landmark file {path} cannot be read: {error.strerror or error}", AGAIN) from error
    except UnicodeDecodeError as error:
        raise RejectedUtterance(f"the landmark file {path.name} is no text (byte {error.start})", AGAIN) from error


@lru_cache(maxsize=1)  # the utterances of a long recording are tracked one after the other
def _read(path: Path, size: int, modified: int) -> dict[str, np.ndarray]:
    with path.open(encoding="utf-8-sig", newline=None) as file:
        return _table(file, path.name)


def _table(file, name: str) -> dict[str, np.ndarray]:
    header = [one.strip().strip('"') for one in _cells(file, name, 1)]
    columns = _columns(header, name)
    rest = [one for one in OPTIONAL if one in columns]
    # Single precision is enough for pixels, and halves what a long file takes.
    points, others, line = array("f"), array("d"), 1
    while cells := _cells(file, name, line + 1):
        line += 1
        if cells == [""]:
            continue
        if line - 1 > MAX_ROWS:
            raise RejectedUtterance(f"the landmark file {name} has more than {MAX_ROWS:,} rows", AGAIN)
        if len(cells) != len(header):
            raise RejectedUtterance(
                f"line {line} of the landmark file {name} has {len(cells)} values, its first line {len(header)} names",
                AGAIN,
            )
        points.extend(_number(cells[columns[one]], one, line, name) for one in POINT_COLUMNS)
        others.extend(_number(cells[columns[one]], one, line, name) for one in rest)
    if not points:
        raise RejectedUtterance(f"the landmark file {name} has no rows", AGAIN)
    found = np.frombuffer(points, np.float32).reshape(-1, 2, POINTS).swapaxes(1, 2)
    values = dict(zip(rest, np.frombuffer(others, np.float64).reshape(len(found), -1).T, strict=True))
    missing = {"frame": np.nan, "timestamp": np.nan, "face_id": 0.0, "confidence": 1.0, "success": 1.0}
    return {"points": found, **{one: values.get(one, np.full(len(found), missing[one])) for one in OPTIONAL}}


def _columns(header: Sequence[str], name: str) -> dict[str, int]:
    """Name of each column that is read -> its position."""
    lacking = [one for one in POINT_COLUMNS if one not in header]
    if not {"frame", "timestamp"} & set(header):
        lacking.insert(0, "frame or timestamp")
    if lacking:
        more = f" and {len(lacking) - 1} more" if len(lacking) > 1 else ""
        raise RejectedUtterance(
            f"the landmark file {name} lacks the column {lacking[0]}{more}",
            "Its first line must name frame or timestamp, x_0 to x_67 and y_0 to y_67, separated by commas.",
        )
    wanted = (*OPTIONAL, *POINT_COLUMNS)
    twice = next((one for one in wanted if header.count(one) > 1), None)
    if twice:
        raise RejectedUtterance(f"the landmark file {name} has the column {twice} twice", AGAIN)
    return {one: header.index(one) for one in wanted if one in header}


def _cells(file, name: str, line: int) -> list[str]:
    """The values of the next line as text; empty at the end of the file."""
    text = file.readline(MAX_LINE + 1)
    if len(text) > MAX_LINE:
        raise RejectedUtterance(f"line {line} of the landmark file {name} has more than {MAX_LINE:,} characters", AGAIN)
    return text.strip().split(",") if text else []


def _number(cell: str, column: str, line: int, name: str) -> float:
    try:
        return float(cell) if cell.strip() else np.nan
    except ValueError:
        raise RejectedUtterance(
            f"line {line} of the landmark file {name}: {column} is {cell.strip()[:20]!r}, no number", AGAIN
        ) from None


def _main_face(table: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The rows of one face: that which is large in most frames."""
    known = np.isfinite(table["face_id"])
    ids = np.unique(table["face_id"][known])
    if not len(ids):
        raise RejectedUtterance("the landmark file has no face_id that is a number", AGAIN)
    if len(ids) == 1 and known.all():
        return table
    with np.errstate(invalid="ignore"):
        size = np.nan_to_num(np.ptp(table["points"][..., 0], axis=1)) * (table["success"] > 0)
    largest = max(ids, key=lambda one: (size[table["face_id"] == one].sum(), -one))
    return {name: values[table["face_id"] == largest] for name, values in table.items()}
