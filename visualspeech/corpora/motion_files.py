"""Files of motion capture: CSV with named channels, Live Link Face, and IEMOCAP's text format.

Nothing of a file is trusted: its size is bounded, columns are found by name, and every mistake is reported with file
and line. Numbers go into one compact array; no more of a file is kept than its wanted columns.
"""

import csv
import io
import math
import os
import re
from array import array
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from visualspeech.corpora.folder_table import csv_mistake
from visualspeech.corpora.records import displayable
from visualspeech.errors import RejectedUtterance
from visualspeech.storage.foreign import read_bytes

MAX_BYTES = 100_000_000  # of a file; ten minutes of 55 markers at 120 frames per second are about that
MAX_COLUMNS = 5_000
MAX_ROWS = 1_000_000
MAX_VALUES = 20_000_000  # rows times wanted columns
AXES = ("x", "y", "z")
#: Columns of times: in seconds, and as hours:minutes:seconds:frames.
TIMES = ("time", "timestamp")
TIMECODE = "timecode"
#: Live Link Face writes how many channels a row holds: none while it sees no face.
COUNT = "blendshapecount"
#: Frames per second that a timecode can count.
TIMECODE_RATES = (24, 25, 30, 48, 50, 60, 100, 120)
USUAL_TIMECODE_RATE = 60  # of Live Link Face
_TIMECODE = re.compile(r"(\d{1,2}):(\d{1,2}):(\d{1,2})[:;](\d{1,3}(?:\.\d{1,9})?)")
_DAY = 86_400  # seconds
_EXPORT = "Export the motion capture again."


@dataclass(frozen=True)
class Recorded:
    """Motion capture as a file holds it.

    Parameters
    ----------
    times : of the T rows, in seconds from the first, ascending, shape (T,)
    points : coordinates of P markers (d = 3) or values of P channels (d = 1), NaN where occluded, shape (T, P, d)
    """

    times: np.ndarray
    points: np.ndarray


def read_csv(path: str | Path, names: Sequence[str], rate: float = 0.0, timecode_rate: float = 0.0) -> Recorded:
    """Read the named markers or channels of a CSV file.

    The first line names the columns; capitals do not count. ``<name>_x``, ``<name>_y`` and ``<name>_z`` are a marker,
    ``<name>`` alone is a channel. A column ``time`` or ``timestamp`` gives seconds, ``timecode`` hours, minutes,
    seconds and frames (``17:32:05:42.512``), as Live Link Face writes it. An empty cell and ``NaN`` are occlusions.

    Parameters
    ----------
    names : wanted markers or channels, all of one kind
    rate : frames per second of a file without times
    timecode_rate : frames that the timecode counts in a second; 0: the usual rate that fits the file

    Raises
    ------
    RejectedUtterance
        The file cannot be read, columns are missing, rows differ in length, a cell is no number, or a time does not
        come after the one before; the reason names the line.
    """
    shown = displayable(os.path.basename(path))
    rows = _csv_rows(path, shown)
    head = [cell.strip().lower() for cell in next(rows, (0, []))[1]]
    while head and not head[-1]:
        head.pop()
    columns, dimensions = _wanted_columns(head, names, shown)
    clock = next((head.index(name) for name in (*TIMES, TIMECODE) if name in head), None)
    if clock is None and not rate:
        raise RejectedUtterance(
            f"{shown} has no column `time` (its columns: {_some(head)})",
            "Name the column of the times in seconds `time`, or set the corpus's `rate` for files without times.",
        )
    count = head.index(COUNT) if COUNT in head else None
    values, lines = array("d"), []
    clocks: list[str] = []
    for line, cells in rows:
        unseen = count is not None and len(cells) > count and cells[count].strip() in ("0", "")
        if any(cell.strip() for cell in cells[len(head) :]) or (len(cells) < len(head) and not unseen):
            raise RejectedUtterance(
                f"{shown}, line {line}: the row has {len(cells)} cells, the first line names {len(head)} columns",
                f"Correct the row. {_EXPORT}",
            )
        _check_size(len(lines), len(values), shown)
        values.extend([math.nan] * len(columns) if unseen else _numbers(cells, columns, head, shown, line))
        lines.append(line)
        clocks.append(cells[clock].strip() if clock is not None else "")
    if not lines:
        raise RejectedUtterance(f"{shown} holds no row below its first line", _EXPORT)
    if clock is None:
        times = np.arange(len(lines)) / rate
    elif head[clock] == TIMECODE:
        times = _timecodes(clocks, lines, timecode_rate, shown)
    else:
        times = np.array([_number(text, shown, line, head[clock]) for text, line in zip(clocks, lines, strict=True)])
    return _recorded(times, values, lines, (len(lines), len(names), dimensions), shown)


def read_iemocap(path: str | Path, names: Sequence[str]) -> Recorded:
    """Read the named markers of a sentence of IEMOCAP's ``MOCAP_rotated``.

    Line 1 names the columns, ``Frame# Time`` and the markers; line 2 names axes; then each line has a frame number, a
    time in seconds and three coordinates per marker in mm, ``NaN`` where it is occluded (Busso et al., 2008; the text
    files of the release).

    Raises
    ------
    RejectedUtterance
        As :func:`read_csv`.
    """
    shown = displayable(os.path.basename(path))
    lines = enumerate(_text(path, shown), 1)
    head = next(lines, (0, ""))[1].split()
    markers = [name.lower() for name in head[2:]]
    if [name.lower() for name in head[:2]] != ["frame#", "time"] or len(markers) > MAX_COLUMNS:
        raise RejectedUtterance(
            f"{shown} is no motion capture of IEMOCAP: its first line does not begin with `Frame# Time`",
            "Restore the file from the corpus.",
        )
    _check_names(markers, names, shown, "markers", "Restore the file from the corpus.")
    first = [2 + 3 * markers.index(name.lower()) for name in names]
    columns = [column + axis for column in first for axis in range(3)]
    labels = ["frame#", "time", *(f"{name}_{axis}" for name in markers for axis in AXES)]
    values, numbers, times = array("d"), [], []
    for line, text in lines:
        cells = text.split()
        if not cells or (line == 2 and not cells[0].lstrip("-").replace(".", "", 1).isdigit()):
            continue
        if len(cells) != len(labels):
            raise RejectedUtterance(
                f"{shown}, line {line}: the row has {len(cells)} numbers, not {len(labels)} (frame, time and three "
                f"coordinates of {len(markers)} markers)",
                "Restore the file from the corpus.",
            )
        _check_size(len(numbers), len(values), shown)
        values.extend(_numbers(cells, columns, labels, shown, line))
        times.append(_number(cells[1], shown, line, "Time"))
        numbers.append(line)
    if not numbers:
        raise RejectedUtterance(f"{shown} holds no frame", "Restore the file from the corpus.")
    return _recorded(np.array(times), values, numbers, (len(numbers), len(names), 3), shown)


def _check_size(rows: int, values: int, shown: str) -> None:
    if rows >= MAX_ROWS or values >= MAX_VALUES:
        raise RejectedUtterance(f"{shown} holds more than {rows:,} rows, too many for one utterance", "Cut the file.")


def _recorded(times: np.ndarray, values: array, lines: Sequence[int], shape: tuple, shown: str) -> Recorded:
    """Checked times and values of a file."""
    if not np.isfinite(times).all():
        line = lines[int(np.argmin(np.isfinite(times)))]
        raise RejectedUtterance(f"{shown}, line {line}: the time is no number", _EXPORT)
    late = np.flatnonzero(np.diff(times) <= 0)
    if len(late):
        row = int(late[0]) + 1
        what = "repeats" if times[row] == times[row - 1] else "is earlier than"
        raise RejectedUtterance(
            f"{shown}, line {lines[row]}: its time, {times[row] - times[0]:.4f} s after the first row, {what} that of "
            f"line {lines[row - 1]}",
            f"Remove repeated rows, and sort the others by time. {_EXPORT}",
        )
    points = np.frombuffer(values, np.float64).reshape(shape)
    if np.isinf(points).any():
        line = lines[int(np.argwhere(np.isinf(points))[0, 0])]
        raise RejectedUtterance(f"{shown}, line {line}: an infinite value", _EXPORT)
    return Recorded(times - times[0], points)


def _wanted_columns(head: Sequence[str], names: Sequence[str], shown: str) -> tuple[list[int], int]:
    """Indices of the columns of the names, those of a marker's axes in turn, and the number of dimensions."""
    if len(head) > MAX_COLUMNS:
        raise RejectedUtterance(f"{shown} has more than {MAX_COLUMNS:,} columns", _EXPORT)
    doubled = sorted({name for name in head if name and head.count(name) > 1}) if len(set(head)) < len(head) else []
    if doubled:
        raise RejectedUtterance(f"{shown} has two columns named `{doubled[0]}`", "Rename or remove one of them.")
    remedy = "Export these channels too, or leave them out of the corpus's `regions`."
    index = {name: number for number, name in enumerate(head)}
    wanted = [name.lower() for name in names]
    axes = [[f"{name}_{axis}" for axis in AXES] for name in wanted]
    markers = [all(axis in index for axis in three) for three in axes]
    if any(markers):
        missing = [name for name, there in zip(names, markers, strict=True) if not there]
        if any(name.lower() in index for name in missing):
            raise RejectedUtterance(
                f"{shown} has single columns of some names ({_some([n for n in missing if n.lower() in index])}) and "
                "three (_x, _y, _z) of others",
                "Give each name a single column, or each three.",
            )
        if missing:
            raise RejectedUtterance(f"{shown} lacks columns _x, _y, _z of {_some(missing)}", remedy)
        return [index[axis] for three in axes for axis in three], 3
    _check_names(head, names, shown, "columns", remedy)
    return [index[name] for name in wanted], 1


def _check_names(there: Sequence[str], names: Sequence[str], shown: str, what: str, remedy: str) -> None:
    known = set(there)
    missing = [name for name in names if name.lower() not in known]
    if missing:
        raise RejectedUtterance(
            f"{shown} lacks {len(missing)} of {len(names)} {what}: {_some(missing)} (there are {_some(there)})", remedy
        )


def _some(names: Sequence[str], most: int = 6) -> str:
    """The first names, as a message lists them."""
    cut = ["".join(one if one.isprintable() else "?" for one in name[:40]) for name in names[:most]]
    return f"{', '.join(cut) or 'none'}{', ...' if len(names) > most else ''}"


def _numbers(cells: Sequence[str], columns: Sequence[int], head: Sequence[str], shown: str, line: int) -> list[float]:
    try:
        return [float(cells[column]) for column in columns]
    except ValueError:
        return [_number(cells[column], shown, line, head[column]) for column in columns]


def _number(cell: str, shown: str, line: int, column: str) -> float:
    """The number in a cell; NaN where it is empty."""
    try:
        return float(cell) if cell.strip() else math.nan
    except ValueError:
        text = cell.strip()[:40]
        raise RejectedUtterance(
            f"{shown}, line {line}: `{column}` is {text!r}, not a number",
            "Write numbers with a point, and leave the cells of occluded markers empty.",
        ) from None


def _timecodes(clocks: Sequence[str], lines: Sequence[int], rate: float, shown: str) -> np.ndarray:
    """Seconds of timecodes; midnight may lie between two."""
    seconds, frames = np.zeros(len(clocks)), np.zeros(len(clocks))
    for row, (text, line) in enumerate(zip(clocks, lines, strict=True)):
        match = _TIMECODE.fullmatch(text)
        if not match:
            raise RejectedUtterance(
                f"{shown}, line {line}: the timecode {text[:40]!r} is not of the form hours:minutes:seconds:frames",
                _EXPORT,
            )
        hours, minutes, whole = map(int, match.groups()[:3])
        seconds[row], frames[row] = 3600 * hours + 60 * minutes + whole, float(match[4])
    crossed = len(set(seconds.tolist())) > 1
    usual = TIMECODE_RATES if crossed else (USUAL_TIMECODE_RATE, 100, 120)
    rate = rate or next((one for one in usual if one > frames.max()), 0)
    if frames.max() >= (rate or 1):
        line = lines[int(frames.argmax())]
        raise RejectedUtterance(
            f"{shown}, line {line}: the timecode counts {frames.max():g} frames in a second, more than its rate "
            f"{rate or TIMECODE_RATES[-1]:g}",
            "Set the corpus's `timecode_rate` to the frames per second of the timecode.",
        )
    times = seconds + frames / rate
    days = np.cumsum(np.diff(times, prepend=times[0]) < -_DAY / 2)
    return times + _DAY * days


def _csv_rows(path: str | Path, shown: str) -> Iterator[tuple[int, list[str]]]:
    """Line number and cells of each row of a CSV or TSV file that holds any text."""
    text = _text(path, shown)
    head = text.readline()
    text.seek(0)
    delimiter = "\t" if "\t" in head else ";" if ";" in head and "," not in head else ","
    reader = csv.reader(text, delimiter=delimiter, strict=True)
    while True:
        line = reader.line_num + 1
        try:
            row = next(reader)
        except StopIteration:
            return
        except csv.Error as error:
            raise RejectedUtterance(f"{shown}, line {line}: {csv_mistake(error)}", _EXPORT) from error
        if any(cell.strip() for cell in row):
            yield line, row


def _text(path: str | Path, shown: str) -> io.TextIOWrapper:
    """The lines of a file, UTF-8, or UTF-16 with a byte-order mark; what is neither becomes replacement characters."""
    try:
        data = read_bytes(path, MAX_BYTES)
    except FileNotFoundError as error:
        raise RejectedUtterance(f"the motion capture {shown} does not exist", "Restore the file.") from error
    except OSError as error:
        raise RejectedUtterance(
            f"the motion capture {shown} cannot be read: {error.strerror or error}", "Restore the file, or cut it."
        ) from error
    encoding = "utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig"
    return io.TextIOWrapper(io.BytesIO(data), encoding=encoding, errors="replace", newline="")
