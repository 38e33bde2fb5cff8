"""Landmarks of the user's own: where the code of a tracker and the files of landmarks lie, found before any job.

Nothing is imported here. A module is looked for as Python would look for it, and its file is read for its digest.
"""

import os
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib.machinery import PathFinder
from itertools import chain
from pathlib import Path

from visualspeech.corpora.files import recordings_digest
from visualspeech.corpora.records import Utterance
from visualspeech.errors import SettingError
from visualspeech.face.landmark_paths import csv_of
from visualspeech.face.tracker import CSV_READER, TRACKERS
from visualspeech.fields import shortened
from visualspeech.provenance import digest, file_digest


@dataclass(frozen=True)
class TrackerCode:
    """The code that gives the landmarks of a run.

    Parameters
    ----------
    module : of this package; empty for a tracker of the user's own
    folder : in which the module of a tracker of the user's own lies; empty if it is installed
    digest : of the files of the user's module; empty for one of this package
    """

    module: str
    folder: str = ""
    digest: str = ""


def tracker_code(landmarks: Mapping, folders: Iterable[str | Path], roots: Iterable[str]) -> TrackerCode:
    """The code that the settings of the landmarks name.

    Parameters
    ----------
    landmarks : section of the run's settings
    folders : where modules of the user may lie: those of the settings files, and the working folder
    roots : folders of recordings, of which no module is taken, because recordings may come from strangers

    Raises
    ------
    SettingError
        There is no such module, or it lies among recordings.
    """
    if landmarks["source"] == "csv":
        return TrackerCode(CSV_READER.partition(":")[0])
    name = landmarks["tracker"]
    if name in TRACKERS:
        return TrackerCode(TRACKERS[name].partition(":")[0])
    module = name.partition(":")[0]
    searched = list(dict.fromkeys(os.path.abspath(folder) for folder in folders))
    for folder in (*searched, ""):
        files = _files(module, [folder] if folder else None)
        if files:
            _check_place(name, files[0], roots)
            return TrackerCode("", folder, digest([(file.name, file_digest(file)) for file in files]))
    raise SettingError(
        f"`landmarks.tracker: {shortened(name)}`: there is no module {module}. It is looked for in "
        f"{', '.join(searched)}, and where Python finds installed modules."
    )


def _files(module: str, path: Sequence[str] | None) -> list[Path]:
    """The file of a module, and where it lies in a package all modules of that package; empty if there is none."""
    names, found = module.split("."), None
    path = [one for one in sys.path if one] if path is None else path
    for number, name in enumerate(names, start=1):
        found = PathFinder.find_spec(name, path)
        if found is None:
            return []
        path = list(found.submodule_search_locations or [])
        if number < len(names) and not path:
            return []
    package = sorted(chain.from_iterable(Path(one).rglob("*.py") for one in path))
    if len(names) > 1 and not path:
        package = sorted(Path(found.origin).parent.rglob("*.py"))
    return [Path(found.origin), *package] if found.origin and os.path.isfile(found.origin) else []


def _check_place(name: str, file: Path, roots: Iterable[str]) -> None:
    real = os.path.realpath(file)
    for root in roots:
        if real.startswith(os.path.join(os.path.realpath(os.path.expanduser(root)), "")):
            raise SettingError(
                f"`landmarks.tracker: {shortened(name)}`: {file} lies among the recordings in {root}, whose code is "
                "never run. Copy it into the folder of your settings file."
            )


def check_landmark_files(landmarks: Mapping, corpora: Mapping[str, Iterable[Utterance]]) -> None:
    """Check that the folder of the landmark files exists, and that no file stands for two recordings.

    Parameters
    ----------
    corpora : name -> utterances with video

    Raises
    ------
    SettingError
        It does not; or the run has recordings and none of them has a file.
    """
    if landmarks["source"] != "csv":
        return
    folder = landmarks["folder"]
    if not os.path.isdir(os.path.expanduser(folder)):
        what = "is a file" if os.path.isfile(os.path.expanduser(folder)) else "does not exist"
        raise SettingError(f"`landmarks.folder: {shortened(folder)}` {what}; give the folder of the CSV files.")
    taken: dict[Path, str] = {}
    media = list(dict.fromkeys(one.media for utterances in corpora.values() for one in utterances if one.media))
    for one in media:
        file = csv_of(folder, one)
        if file is not None and taken.setdefault(file, one) != one:
            raise SettingError(
                f"`landmarks.folder`: {file} would stand for {taken[file]} and for {one}. Put the CSV files into "
                "folders named as those of the recordings."
            )
    if media and not taken:
        raise SettingError(
            f"`landmarks.folder: {shortened(folder)}` holds no file for any recording; for {media[0]} it would be "
            f"{Path(media[0]).stem}.csv."
        )


def landmark_files_digest(landmarks: Mapping, utterances: Iterable[Utterance], by_content: bool = False) -> str:
    """Digest of the landmark files of utterances, which changes with them; empty where landmarks are tracked."""
    if landmarks["source"] != "csv":
        return ""
    files = [csv_of(landmarks["folder"], media) for media in sorted({one.media for one in utterances if one.media})]
    return recordings_digest((Utterance("", "", str(file), "") for file in files if file), by_content)
