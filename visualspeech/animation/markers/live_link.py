"""The CSV files of Live Link Face, whose channels have the names of ARKit's blend shapes.

A file has the columns Timecode (hours:minutes:seconds:frames.fraction of a frame), BlendShapeCount (61) and 61 channels
in a fixed order. Channels that are not given are 0.
"""

from collections.abc import Mapping
from functools import cache
from pathlib import Path

import numpy as np

from visualspeech.errors import DataError
from visualspeech.settings import read_yaml
from visualspeech.storage.files import write_text

FOLDER = Path(__file__).parent / "standards"
BLEND_SHAPES = 52


@cache
def channels() -> Mapping[str, float]:
    """Name -> what the range of an actor's motion is scaled to, in the order of the columns."""
    return {name: float(most) for name, most in read_yaml(FOLDER / "live_link.yaml")["channels"].items()}


def write_live_link(path: str | Path, values: Mapping[str, np.ndarray], rate: float) -> None:
    """Write a Live Link Face CSV.

    Parameters
    ----------
    values : name of a channel -> (T,); blend shapes are limited to 0 to 1, rotations are in radians
    rate : frame rate in Hz; timecodes count whole frames per second

    Raises
    ------
    DataError
        A channel is unknown, lengths differ, a value is not finite, or the rate is not a whole number.
    StorageError
        The file cannot be written.
    """
    names = list(channels())
    unknown = sorted(set(values) - set(names))
    lengths = {len(one) for one in values.values()}
    if unknown or len(lengths) != 1:
        raise DataError(f"Live Link file {path}: unknown channels {unknown}, lengths {sorted(lengths)}; one is needed.")
    if rate != round(rate) or rate < 1:
        raise DataError(f"Live Link file {path}: {rate:g} frames per second have no timecodes. Resample.")
    table = np.zeros((lengths.pop(), len(names)))
    for name, series in values.items():
        table[:, names.index(name)] = series
    if not np.isfinite(table).all():
        raise DataError(f"Live Link file {path}: there are values that are not finite.")
    table[:, :BLEND_SHAPES] = np.clip(table[:, :BLEND_SHAPES], 0, 1)
    lines = [",".join(["Timecode", "BlendShapeCount", *names])]
    for index, row in enumerate(table):
        lines.append(",".join([timecode(index, int(rate)), str(len(names)), *(f"{value:.6f}" for value in row)]))
    write_text(path, "\n".join(lines) + "\n")


def timecode(frame: int, rate: int) -> str:
    """Timecode of a frame, hours:minutes:seconds:frames.fraction."""
    seconds, within = divmod(frame, rate)
    return f"{seconds // 3600:02d}:{seconds // 60 % 60:02d}:{seconds % 60:02d}:{within:02d}.000"
