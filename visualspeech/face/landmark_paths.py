"""Where the landmark file of a recording lies."""

from os import path as paths
from pathlib import Path


def csv_candidates(folder: str, media: str) -> list[Path]:
    """Where the landmarks of a recording may lie, the first choice first.

    ``folder/b/name.csv`` goes before ``folder/name.csv`` for the recording ``/a/b/name.mp4``, so that recordings of the
    same name in several folders can each have a file.
    """
    root, file = Path(paths.expanduser(folder)), Path(media)
    above = [part for part in file.parent.parts if part not in (file.anchor, "..", ".")]
    return [Path(root, *above[start:], f"{file.stem}.csv") for start in range(len(above) + 1)]


def csv_of(folder: str, media: str) -> Path | None:
    """The landmark file of a recording (:func:`csv_candidates`); None if there is none."""
    return next((one for one in csv_candidates(folder, media) if paths.lexists(one)), None)
