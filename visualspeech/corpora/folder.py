"""The adapter ``folder``: recordings in a folder, with a ``.txt`` transcript beside each or one table for all."""

import csv
import difflib
import os
from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from visualspeech.corpora.records import Utterance, legal_id
from visualspeech.errors import CorpusError, SettingError

VIDEOS = frozenset(
    ".3g2 .3gp .asf .avi .divx .dv .f4v .flv .gif .m2ts .m2v .m4v .mkv .mov .mp4 .mpe .mpeg .mpg .mts .mxf .ogm .ogv "
    ".qt .rm .ts .vob .webm .wmv".split()
)
NEEDED = ("file", "transcript")
OPTIONAL = ("id", "speaker", "split", "emotion", "start", "end")


def utterances(corpus: Mapping) -> list[Utterance]:
    """List the recordings of a folder and of all folders inside it, sorted by file.

    Parameters
    ----------
    corpus : settings. ``root``: the folder. ``table`` (optional): a TSV or CSV file with a header line, inside or
        outside the root, one row per utterance: ``file`` (relative to the root), ``transcript`` and optionally ``id``,
        ``speaker``, ``split``, ``emotion``, ``start`` and ``end`` (seconds). Without a table the transcript of a video
        is the ``.txt`` file of the same name. The speaker is that of the table, or the name of the recording's folder.
        ``speaker`` (optional): use the recordings of this speaker only; if recordings have no speaker, their speaker.

    Returns
    -------
    Utterances. A missing transcript is empty; the check of the recordings rejects it.

    Raises
    ------
    SettingError
        ``root`` is not a folder, or ``table`` is not a file.
    CorpusError
        There is no recording, none of the speaker, or the table cannot be read.
    """
    root = existing_folder(corpus.get("root"), corpus)
    found = _of_table(root, corpus) if corpus.get("table") else _of_files(root, corpus)
    return _of_speaker(found, str(corpus.get("speaker") or ""), str(corpus.get("name") or root.name), root)


def _of_speaker(utterances: list[Utterance], wanted: str, name: str, root: Path) -> list[Utterance]:
    """The utterances of one speaker, or of all; recordings without a speaker get the wanted one, else ``name``."""
    speakers = sorted({one.speaker for one in utterances})
    if wanted and speakers != [""]:
        utterances = [one for one in utterances if one.speaker == wanted]
        if not utterances:
            raise CorpusError(
                f"no recordings of the speaker {wanted!r} in {root.absolute()}; there are "
                f"{', '.join(one or 'recordings without a speaker' for one in speakers)}. Set `speaker` to one of them."
            )
    return [replace(one, speaker=one.speaker or wanted or name) for one in utterances]


def existing_folder(root: str | os.PathLike | None, corpus: Mapping, also: str = "") -> Path:
    """The root folder of a corpus.

    Parameters
    ----------
    corpus : settings, for the name in messages
    also : other ways to give the root, for messages

    Raises
    ------
    SettingError
        It is not set, or there is no such folder.
    """
    name = corpus.get("name", "?")
    if not root:
        raise SettingError(f"the corpus {name!r} has no `root`. Set `root:` to the folder of its recordings{also}.")
    path = Path(root).expanduser()
    if not path.is_dir():
        what = "is a file, not a folder" if path.is_file() else "does not exist"
        raise SettingError(
            f"the root of the corpus {name!r} {what}: {path.absolute()}. Set `root:` to the folder of its "
            f"recordings{also}; a relative path is relative to the folder in which snakemake runs."
        )
    return path


def find_files(root: Path, suffixes: frozenset[str]) -> list[Path]:
    """All files below a folder with one of the suffixes (lower case, with dot), sorted; hidden ones are left out."""
    found = []
    for folder, folders, files in os.walk(root, followlinks=True):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        found += [Path(folder, name) for name in files if not name.startswith(".") and suffix(name) in suffixes]
    return sorted(found)


def suffix(name: str) -> str:
    return os.path.splitext(name)[1].lower()


def read_transcript(path: Path) -> str:
    """Text of a file as one line; UTF-8 (with or without a byte-order mark), UTF-16 with one, or else Windows-1252."""
    data = path.read_bytes()
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return one_line(data.decode("utf-16", "replace"))
    try:
        return one_line(data.decode("utf-8-sig"))
    except UnicodeDecodeError:
        return one_line(data.decode("cp1252", "replace"))


def one_line(text: str) -> str:
    return " ".join(text.replace("\0", " ").split())


def _of_files(root: Path, corpus: Mapping) -> list[Utterance]:
    videos = find_files(root, VIDEOS)
    if not videos:
        raise CorpusError(
            f"no recordings in {root.absolute()}. Put videos (such as .mp4, .mov, .mkv, .avi, .mpg) there with a .txt "
            "transcript of the same name beside each, or set `root:` to the folder that holds them."
        )
    found = []
    for video in videos:
        text = next((path for path in (video.with_suffix(".txt"), video.with_suffix(".TXT")) if path.is_file()), None)
        found.append(
            Utterance(
                id=legal_id("-".join(video.relative_to(root).with_suffix("").parts)),
                speaker=_speaker(video, root),
                media=str(video),
                transcript=read_transcript(text) if text else "",
            )
        )
    return found


def _speaker(video: Path, root: Path) -> str:
    """Name of the folder of a recording; empty if that is the root."""
    return video.parent.name if video.parent != root else ""


def _of_table(root: Path, corpus: Mapping) -> list[Utterance]:
    path = next((one for one in (root / corpus["table"], Path(corpus["table"])) if one.is_file()), None)
    if path is None:
        raise SettingError(
            f"the table {corpus['table']} of the corpus {corpus.get('name', '?')!r} does not exist. Set `table:` to a "
            f"TSV or CSV file, with a path relative to the root {root.absolute()}."
        )
    rows = _rows(path)
    counts = Counter(row["file"] for row in rows)
    several = {file for file, count in counts.items() if count > 1}
    if not rows:
        raise CorpusError(f"the table {path} has no rows. Write one row per recording below its header line.")
    return [_of_row(row, number, path, root, several) for number, row in enumerate(rows, start=2)]


def _rows(path: Path) -> list[dict[str, str]]:
    lines = _decoded(path).splitlines()
    head = next((line for line in lines if line.strip()), "")
    delimiter = "\t" if "\t" in head else ";" if ";" in head and "," not in head else ","
    # In CSV quotes enclose a cell; in TSV a transcript may begin with one.
    quoting = csv.QUOTE_NONE if delimiter == "\t" and suffix(path.name) != ".csv" else csv.QUOTE_MINIMAL
    reader = csv.reader(lines, delimiter=delimiter, quoting=quoting)
    table = [[cell.strip() for cell in row] for row in reader if any(cell.strip() for cell in row)]
    names = [name.lower() for name in table[0]] if table else []
    _check_names(names, path)
    return [dict(zip(names, row + [""] * (len(names) - len(row)), strict=False)) for row in table[1:]]


def _decoded(path: Path) -> str:
    data = path.read_bytes()
    encoding = "utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig"
    try:
        return data.decode(encoding)
    except UnicodeDecodeError as error:
        raise CorpusError(f"the table {path} is not UTF-8 text (byte {error.start}). Save it as UTF-8.") from error


def _check_names(names: list[str], path: Path) -> None:
    for name in NEEDED:
        if name not in names:
            raise CorpusError(
                f"the table {path} has no column `{name}` (its columns: {', '.join(names) or 'none'}). Its first line "
                "must name the columns `file` and `transcript`, separated by tabs or commas."
            )
    for name in set(names):
        if names.count(name) > 1:
            raise CorpusError(f"the table {path} has two columns named `{name}`. Remove or rename one.")
        meant = difflib.get_close_matches(name, NEEDED + OPTIONAL, 1, 0.8)
        if meant and name not in NEEDED + OPTIONAL and meant[0] not in names:
            raise CorpusError(f"the table {path} has a column `{name}`; if `{meant[0]}` is meant, rename it.")


def _of_row(row: dict[str, str], number: int, path: Path, root: Path, several: set[str]) -> Utterance:
    if not row["file"]:
        raise CorpusError(f"{path}, line {number}: the column `file` is empty. Name the recording, or remove the line.")
    video = root / row["file"]
    start, end = (_seconds(row.get(name, ""), name, number, path) for name in ("start", "end"))
    if end and end <= start:
        raise CorpusError(f"{path}, line {number}: `end` {end:g} is not after `start` {start:g}. Give seconds.")
    stem = "-".join(Path(row["file"]).with_suffix("").parts)
    made = f"{legal_id(stem)}-{number - 1:04d}" if row["file"] in several else legal_id(stem)
    return Utterance(
        id=row.get("id") or made,
        speaker=row.get("speaker") or _speaker(video, root),
        media=str(video),
        transcript=one_line(row["transcript"]),
        split=row.get("split", "").lower(),
        emotion=row.get("emotion", ""),
        start=start,
        end=end,
    )


def _seconds(text: str, name: str, number: int, path: Path) -> float:
    try:
        value = float(text or 0)
    except ValueError:
        value = -1.0
    if not 0 <= value < 1e7:
        raise CorpusError(f"{path}, line {number}: `{name}` is {text!r}, not a time. Give seconds such as 12.48.")
    return value
