"""The files of a corpus as they lie on a disk: found below a root, read as text, and watched for changes."""

import os
import stat
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from visualspeech.corpora.records import Utterance, displayable, legal_id
from visualspeech.errors import CorpusError
from visualspeech.provenance import digest, file_digest
from visualspeech.storage.foreign import decoded, read_bytes

VIDEOS = frozenset(
    ".3g2 .3gp .asf .avi .divx .dv .f4v .flv .gif .m2ts .m2v .m4v .mkv .mov .mp4 .mpe .mpeg .mpg .mts .mxf .ogm .ogv "
    ".qt .rm .ts .vob .webm .wmv".split()
)
#: Folders without a file that is looked for, in excess of twice the files found, after which a search is given up.
MAX_FOLDERS = 20_000
#: File systems that the kernel makes up.
_PSEUDO = frozenset(
    "autofs binfmt_misc bpf cgroup cgroup2 configfs debugfs devpts devtmpfs efivarfs fusectl hugetlbfs mqueue proc "
    "pstore securityfs selinuxfs sysfs tracefs".split()
)
#: Folders of operating systems, which may be unreadable and hold no recordings.
_OF_SYSTEM = frozenset({"lost+found", "System Volume Information", "$RECYCLE.BIN"})


@dataclass(frozen=True)
class Found:
    """What lies below a folder.

    Parameters
    ----------
    files : paths, sorted; a file is listed once, however many links lead to its folder
    unreadable : (path, reason) of each folder that cannot be listed, sorted
    """

    files: list[Path]
    unreadable: list[tuple[Path, str]]


def find_files(root: Path, suffixes: Collection[str]) -> Found:
    """All files below a folder with one of the suffixes (lower case, with dot); hidden ones are left out.

    Links are followed after the folders beside them, so that a folder is found at its own place if that is below the
    root. File systems that the kernel makes up, such as ``/proc``, are left out.

    Raises
    ------
    CorpusError
        The root cannot be listed, or is so large that it can be no folder of recordings.
    """
    pseudo = _pseudo_devices()
    files: list[Path] = []
    unreadable: list[tuple[Path, str]] = []
    seen: set[tuple[int, int]] = set()
    folders, links, empty = [str(root)], [], 0
    while folders or links:
        folder = folders.pop() if folders else links.pop(0)
        try:
            status = os.stat(folder)
            if status.st_ino and (status.st_dev, status.st_ino) in seen:
                continue
            seen.add((status.st_dev, status.st_ino))
            if status.st_dev in pseudo:
                if folder == str(root):
                    raise CorpusError(
                        f"{shown(root)} lies on a file system of the operating system ({pseudo[status.st_dev]}), "
                        "which holds no recordings. Set `root:` to the folder of the recordings."
                    )
                continue
            names, below, linked = _entries(folder, suffixes)
        except OSError as error:
            reason = error.strerror or str(error)
            if folder == str(root):
                raise CorpusError(
                    f"cannot read the folder {shown(root)}: {reason}. Give yourself the right to read it, or set "
                    "`root:` to another folder."
                ) from error
            unreadable += [(Path(folder), reason)] if os.path.basename(folder) not in _OF_SYSTEM else []
            continue
        files += [Path(folder, name) for name in names]
        folders += [os.path.join(folder, name) for name in sorted(below, reverse=True)]
        links += [os.path.join(folder, name) for name in sorted(linked)]
        empty += not names
        if empty > MAX_FOLDERS + 2 * len(files):
            raise CorpusError(
                f"{shown(root)} holds more than {MAX_FOLDERS:,} folders without a recording; the search for "
                f"recordings was given up in {displayable(folder)}. Set `root:` to the folder that holds the "
                "recordings alone."
            )
    return Found(sorted(files), sorted(unreadable))


def _entries(folder: str, suffixes: Collection[str]) -> tuple[list[str], list[str], list[str]]:
    """Names in a folder that are not hidden: files with one of the suffixes, folders, and links to folders."""
    files, folders, links = [], [], []
    with os.scandir(folder) as entries:
        for entry in entries:
            if entry.name.startswith("."):
                continue
            if _is_folder(entry):
                (links if entry.is_symlink() else folders).append(entry.name)
            elif suffix(entry.name) in suffixes:
                files.append(entry.name)
    return files, folders, links


def _is_folder(entry: os.DirEntry) -> bool:
    try:
        return entry.is_dir()
    except OSError:  # a link that leads to itself
        return False


def _pseudo_devices() -> dict[int, str]:
    """Device number -> file system, of those that the kernel makes up; empty where that cannot be learned."""
    found = {}
    try:
        with open("/proc/self/mountinfo", encoding="utf-8", errors="replace") as lines:
            for line in lines:
                mount, _, source = line.partition(" - ")
                major, minor = mount.split()[2].split(":")
                kind = source.split()[0]
                if kind in _PSEUDO:
                    found[os.makedev(int(major), int(minor))] = kind
    except (OSError, ValueError, IndexError):
        return {}
    return found


def unreadable_folders(found: Found, root: Path, speaker_of) -> Iterator[Utterance]:
    """An utterance with a problem for each folder that cannot be listed, so that the check reports it.

    Parameters
    ----------
    speaker_of : function of the path of a file and the root, that gives the speaker of the file
    """
    for folder, reason in found.unreadable:
        inside = folder.relative_to(root)
        yield Utterance(
            id=legal_id("-".join(inside.parts) + "/"),
            speaker=displayable(speaker_of(folder / "any", root)),
            media=displayable(str(folder)),
            transcript="",
            problem=f"the folder cannot be read: {reason}",
            remedy="Give yourself the right to read it, or move it out of the corpus's root.",
        )


def speaker_folder(path: Path, root: Path) -> str:
    """Name of the folder of a recording; empty if that is the root."""
    return path.parent.name if path.parent != root else ""


def shown(path: Path) -> str:
    """An absolute path as messages show it."""
    return displayable(str(path.absolute()))


def suffix(name: str) -> str:
    """Suffix of a file name, in lower case, with its dot."""
    return os.path.splitext(name)[1].lower()


def recording_fields(path: Path, field: str = "media") -> dict[str, str]:
    """Fields ``media`` (or another one), ``problem`` and ``remedy`` of an utterance whose recording is a file."""
    media = displayable(str(path))
    if media == str(path):
        return {field: media}
    return {
        field: media,
        "problem": "its file name is not UTF-8 text, or holds a carriage return",
        "remedy": "Rename the file or folder; letters of any script can be used.",
    }


def read_transcript(path: str | Path) -> str:
    """Text of a file as one line; UTF-8 (with or without a byte-order mark), UTF-16 with one, or else Windows-1252.

    Raises
    ------
    OSError
        As :func:`read_bytes`.
    """
    return one_line(decoded(read_bytes(path)))


def one_line(text: str) -> str:
    """A text with each run of white space, line breaks included, replaced by one space."""
    return " ".join(text.replace("\0", " ").split())


def recordings_digest(utterances: Iterable[Utterance], by_content: bool = False) -> str:
    """Digest of the recordings of utterances, which changes when a file is changed, replaced, added or deleted.

    Parameters
    ----------
    by_content : of what is in the files, which are then read, and not of their size and time of modification
    """
    return files_digest((path for one in utterances for path in (one.media, one.audio, one.motion) if path), by_content)


def files_digest(paths: Iterable[str], by_content: bool = False) -> str:
    """As :func:`recordings_digest`, of files."""
    return digest([(path, _state(path, by_content)) for path in sorted(set(paths))])


def _state(path: str, by_content: bool):
    """What a change of a file changes; None where there is no such file."""
    try:
        status = os.stat(path)
        if by_content and stat.S_ISREG(status.st_mode):
            return file_digest(path)
    except (OSError, ValueError):
        return None
    return [status.st_size, status.st_mtime_ns]
