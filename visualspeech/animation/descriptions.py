"""The JSON file by which a folder tells what it is: a speaker, or a background."""

from collections.abc import Mapping
from pathlib import Path

from visualspeech.errors import DamagedFile, StorageError, plain_reason
from visualspeech.storage.files import read_text
from visualspeech.storage.layouts import check_plain, parse_plain


def read_description(path: Path, noun: str, kind: str, version: int, schema: Mapping, origin: str, remedy: str) -> dict:
    """What the description of a folder says, checked.

    Parameters
    ----------
    noun : what the folder is, for messages
    kind, version : that the description must have
    schema : JSON Schema of the whole description
    origin : sentence that says which folder to give
    remedy : sentence that says what to do about a damaged one

    Raises
    ------
    StorageError
        There is none, it is damaged, or it is of another kind or version.
    """
    if not path.is_file():
        raise StorageError(f"{path.parent} is no {noun}: it holds no {path.name}. {origin}")
    try:
        about = parse_plain(read_text(path))
        known = isinstance(about, dict) and about.get("kind") == kind
        if known and about.get("version") != version:
            found = str(about.get("version"))[:20]
            raise StorageError(
                f"{path.parent} is a {noun} of version {found}, but this program reads version {version}. {remedy}"
            )
        if not known:
            raise DamagedFile(path, f"it does not describe a {noun} of this project")
        check_plain(path, about, schema)
    except DamagedFile as error:
        raise DamagedFile(path, error.reason, remedy) from error
    except (ValueError, RecursionError) as error:
        raise DamagedFile(path, f"it is no JSON ({plain_reason(error)})", remedy) from error
    return about
