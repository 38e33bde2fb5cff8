"""Paths on a command line: what may be written, checked before any work, and what must not be replaced."""

import os
from collections.abc import Mapping
from pathlib import Path

from visualspeech.errors import SettingError, StorageError
from visualspeech.fields import shortened
from visualspeech.storage.files import check_writable

#: Bytes of a name and of a path.
MAX_NAME, MAX_PATH = 255, 4000


def background_folder(background: str | Path) -> Path | None:
    """The folder that a background is; None where it is the name of a recording of the speaker's own background."""
    return Path(background) if os.sep in str(background) or os.path.isdir(background) else None


def check_outputs(
    files: Mapping[str, Path], folders: Mapping[str, Path], inputs: Mapping[str, Path], model: Path
) -> None:
    """Check that outputs can be written, that none replaces an input or another output, and that no folder is in use.

    Parameters
    ----------
    files, folders : option of the command line -> path to write; a folder must be new or empty
    inputs : option -> path that is read
    model : folder of the speaker, which nothing is written into

    Raises
    ------
    SettingError
        Another name must be given.
    StorageError
        A path cannot be written.
    """
    for option, path in files.items():
        _check_name(option, path)
        if path.is_dir():
            raise SettingError(f"{option} {path} is a folder; give the name of a file.")
        if path.exists() and not path.is_file():
            raise SettingError(f"{option} {path} is a device or pipe; give the name of a file.")
    for option, path in folders.items():
        _check_name(option, path)
        _check_unused(option, path)
    for option, path in {**files, **folders}.items():
        same = next((other for other, one in inputs.items() if _is_same(path, one)), None)
        if same:
            raise SettingError(f"{option} {path} is the file of {same}, which would be replaced; give another name.")
        within = next((other for other, one in inputs.items() if one.is_dir() and _is_part(path, one)), None)
        if within:
            raise SettingError(f"{option} {path} lies in the folder of {within}; give a path outside.")
        if _is_part(path, model):
            raise SettingError(f"{option} {path} is a part of the speaker {model}; give another name.")
    _check_apart(files, folders)
    for path in (*files.values(), *folders.values()):
        check_writable(path)


def _check_name(option: str, path: Path) -> None:
    size = len(os.fsencode(path.name))
    if not size:
        raise SettingError(f"{option} {shortened(path)} is no name of a file or folder; give one.")
    if size > MAX_NAME:
        raise SettingError(f"{option}: the name of the file has {size} bytes; give one of at most {MAX_NAME}.")
    if any(len(os.fsencode(part)) > MAX_NAME for part in path.parts) or len(os.fsencode(path.absolute())) > MAX_PATH:
        raise SettingError(
            f"{option}: a path has at most {MAX_PATH} bytes, and the name of a folder at most {MAX_NAME}; give a "
            "shorter one."
        )
    if any("\ud800" <= character <= "\udfff" for character in str(path)):
        raise SettingError(f"{option} {shortened(path)}: the path is not UTF-8 text; give another.")


def _check_unused(option: str, path: Path) -> None:
    """Check that a path is no file and no folder with anything in it, which would be lost."""
    if path.is_symlink() or (path.exists() and not path.is_dir()):
        raise SettingError(f"{option} {path} is not a folder; give the name of a new one.")
    try:
        used = path.is_dir() and any(path.iterdir())
    except OSError as error:
        raise StorageError(f"cannot read {path}: {error.strerror}. Give the name of a new folder.") from error
    if used:
        raise SettingError(f"{option} {path} is a folder that holds files; give a new or an empty one.")


def _check_apart(files: Mapping[str, Path], folders: Mapping[str, Path]) -> None:
    """Check that no two outputs are one, and none lies in a folder that is written as a whole."""
    named = list({**files, **folders}.items())
    for number, (option, path) in enumerate(named):
        for other, one in named[number + 1 :]:
            if _is_same(path, one):
                raise SettingError(f"{option} and {other} are both {path}; give two names.")
    for option, folder in folders.items():
        for other, one in named:
            if one is not folder and os.path.realpath(folder) in map(os.path.realpath, one.absolute().parents):
                raise SettingError(
                    f"{other} {one} lies in the folder of {option}, which is written as a whole; give a path outside."
                )


def _is_same(path: Path, other: Path) -> bool:
    """Whether two paths lead to one file, by whatever links and spellings."""
    if os.path.realpath(path) == os.path.realpath(other):
        return True
    try:
        return os.path.samefile(path, other)
    except OSError:
        return False


def _is_part(path: Path, folder: Path) -> bool:
    """Whether a path is a folder or lies in it, also by a link, or is one of its files."""
    try:
        above = (path.absolute(), *path.absolute().parents)
        return os.path.realpath(folder) in map(os.path.realpath, above) or any(
            _is_same(path, one) for one in folder.iterdir()
        )
    except OSError:  # there is no such folder
        return False
