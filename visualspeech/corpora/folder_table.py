"""The table of a folder of recordings: a TSV or CSV file with one row per utterance."""

import csv
import difflib
import io
import os
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from visualspeech.corpora.files import VIDEOS, one_line, recording_fields, shown, speaker_folder, suffix
from visualspeech.corpora.records import Utterance, check_id, displayable, legal_id
from visualspeech.errors import CorpusError, SettingError

NEEDED = ("file", "transcript")
OPTIONAL = ("id", "speaker", "split", "emotion", "start", "end")
#: What Python's reader says, and what this project says for it.
_CSV_ERRORS = {
    "unexpected end of data": "a quote is not closed",
    "expected after": "a text follows a closing quote",
    "field larger than field limit": f"a cell has more than {csv.field_size_limit():,} characters",
}
#: Files that a row can name; a cell that holds another row names one too.
_RECORDINGS = VIDEOS | {".csv"}
_ONE_LINE = ("file", "audio", *OPTIONAL)
_URL = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+://|(file|data|pipe):", re.IGNORECASE)


@dataclass(frozen=True)
class Row:
    """One row below the head.

    Parameters
    ----------
    where : file and line, for messages
    cells : column -> text, without white space around it; empty where the row is shorter than the head
    """

    where: str
    cells: Mapping[str, str]


def table_utterances(root: Path, corpus: Mapping) -> list[Utterance]:
    """The utterances of the corpus's ``table``, in its order; see :func:`visualspeech.corpora.folder.utterances`.

    Raises
    ------
    SettingError, CorpusError
        As :func:`numbered_rows`; or a cell is invalid.
    """
    rows = numbered_rows(root, corpus)
    return [
        Utterance(**row_fields(row, number, root), **recording_fields(root / row.cells["file"])) for row, number in rows
    ]


def numbered_rows(
    root: Path, corpus: Mapping, needed: Sequence[str] = NEEDED, optional: Sequence[str] = OPTIONAL
) -> list[tuple[Row, int]]:
    """The rows of the corpus's ``table``, each with the number that tells utterances of one file apart, or 0.

    Raises
    ------
    SettingError
        There is no such file.
    CorpusError
        It is no such table; the message names the line.
    """
    path = next((one for one in (root / corpus["table"], Path(corpus["table"])) if os.path.isfile(one)), None)
    if path is None:
        raise SettingError(
            f"the table {corpus['table']} of the corpus {corpus.get('name', '?')!r} does not exist. Set `table:` to a "
            f"TSV or CSV file, with a path relative to the root {shown(root)}."
        )
    rows = read_rows(path, needed, optional)
    if not rows:
        raise CorpusError(f"the table {path} has no rows. Write one row per recording below its header line.")
    counts = Counter(row.cells["file"] for row in rows)
    return [(row, number if counts[row.cells["file"]] > 1 else 0) for number, row in enumerate(rows, 1)]


def read_rows(path: Path, needed: Sequence[str] = NEEDED, optional: Sequence[str] = OPTIONAL) -> list[Row]:
    """The rows of a TSV or CSV file with a header line; rows without any text are left out.

    Lines end at a line feed, a carriage return, or both, and nowhere else. In a CSV file quotes enclose a cell, which
    may hold commas and line breaks; in a TSV file quotes are text.

    Raises
    ------
    CorpusError
        The file is not UTF-8 or UTF-16 text, columns are missing, or a row cannot be read as the columns say.
    """
    text = _decoded(path)
    head = next((line for line in re.split(r"[\r\n]", text) if line.strip()), "")
    delimiter = "\t" if "\t" in head else ";" if ";" in head and "," not in head else ","
    quoted = delimiter != "\t" or suffix(path.name) == ".csv"
    lines = list(_lines(path, text, delimiter, quoted))
    names = [name.lower() for name in lines[0][1]] if lines else []
    while names and not names[-1]:
        names.pop()
    _check_names(names, path, needed, optional)
    return [Row(where, _cells(where, row, names, delimiter, quoted)) for where, row in lines[1:]]


def _lines(path: Path, text: str, delimiter: str, quoted: bool) -> Iterator[tuple[str, list[str]]]:
    """Each row that holds any text, with its file and line."""
    quoting = csv.QUOTE_MINIMAL if quoted else csv.QUOTE_NONE
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter, quoting=quoting, strict=True)
    while True:
        where = f"{path}, line {reader.line_num + 1}"
        try:
            row = [cell.strip() for cell in next(reader)]
        except StopIteration:
            return
        except csv.Error as error:
            raise CorpusError(
                f"{where}: {csv_mistake(error)} (up to line {reader.line_num}). Close each quote in its cell, and "
                'write a quote inside a quoted cell twice ("").'
            ) from error
        if any(row):
            yield where, row


def csv_mistake(error: csv.Error) -> str:
    """What Python's reader found wrong, as this project says it."""
    return next((sentence for words, sentence in _CSV_ERRORS.items() if words in str(error)), str(error))


def _cells(where: str, row: list[str], names: list[str], delimiter: str, quoted: bool) -> dict[str, str]:
    """Column -> cell of a row.

    Raises
    ------
    CorpusError
        There are more cells than columns, or a cell holds the rows after it.
    """
    if any(row[len(names) :]):
        name = {"\t": "tab", ",": "comma", ";": "semicolon"}[delimiter]
        remedy = "Put a text that holds one in double quotes" if quoted else "Take it out of the text"
        raise CorpusError(
            f"{where}: the row has {len(row)} cells, and the first line names {len(names)} columns; a {name} separates "
            f"cells. {remedy}, or correct the row."
        )
    cells = dict(zip(names, row + [""] * (len(names) - len(row)), strict=False))
    for name, cell in cells.items():
        if "\n" not in cell and "\r" not in cell:
            continue
        lines = re.split(r"[\r\n]+", cell)[1:]
        first = [line.split(delimiter)[0].strip(' "') for line in lines if delimiter in line]
        if name in _ONE_LINE or any(suffix(one) in _RECORDINGS for one in first):
            raise CorpusError(
                f"{where}: the cell in the column `{name}` goes on in the next line. Close its quote, or remove the "
                "line break."
            )
    return cells


def _decoded(path: Path) -> str:
    try:
        data = path.read_bytes()
        text = data.decode("utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig")
    except OSError as error:
        raise CorpusError(
            f"the table {path} cannot be read: {error.strerror}. Give yourself the right to read it."
        ) from error
    except UnicodeDecodeError as error:
        raise CorpusError(f"the table {path} is not UTF-8 text (byte {error.start}). Save it as UTF-8.") from error
    if "\0" in text:
        line = len(re.findall(r"\r\n|\r|\n", text[: text.index("\0")])) + 1
        raise CorpusError(f"{path}, line {line}: a null character; the file is no text or damaged. Save it as UTF-8.")
    return text


def _check_names(names: list[str], path: Path, needed: Sequence[str], optional: Sequence[str]) -> None:
    known = [*needed, *optional]
    for name in needed:
        if name not in names:
            wanted = " and ".join(f"`{one}`" for one in needed)
            raise CorpusError(
                f"the table {path} has no column `{name}` (its columns: {', '.join(names) or 'none'}). Its first line "
                f"must name the column{'s' * (len(needed) > 1)} {wanted}, separated by tabs or commas."
            )
    for name in set(names):
        if names.count(name) > 1:
            raise CorpusError(f"the table {path} has two columns named `{name}`. Remove or rename one.")
        meant = difflib.get_close_matches(name, known, 1, 0.8)
        if meant and name not in known and meant[0] not in names:
            raise CorpusError(f"the table {path} has a column `{name}`; if `{meant[0]}` is meant, rename it.")


def row_fields(row: Row, number: int, root: Path) -> dict:
    """The fields of the utterance of a row but for its files; with a number, its id ends in it.

    Raises
    ------
    CorpusError
        A cell is invalid; the message names file and line.
    """
    cells, where = row.cells, row.where
    file = checked_path(cells["file"], where)
    start, end = (_seconds(cells.get(name, ""), name, where) for name in ("start", "end"))
    if end and end <= start:
        raise CorpusError(f"{where}: `end` {end:g} is not after `start` {start:g}. Give seconds.")
    if cells.get("id"):
        check_id(cells["id"], where)
    stem = "-".join(Path(file).with_suffix("").parts)
    return {
        "id": cells.get("id") or legal_id(f"{stem}-{number:04d}" if number else stem),
        "speaker": cells.get("speaker") or displayable(speaker_folder(root / file, root)),
        "transcript": one_line(cells.get("transcript", "")),
        "split": cells.get("split", "").lower(),
        "emotion": cells.get("emotion", ""),
        "start": start,
        "end": end,
    }


def checked_path(cell: str, where: str) -> str:
    """The cell of the column ``file``, as it stands: a path, relative to the root or absolute."""
    if not cell:
        raise CorpusError(f"{where}: the column `file` is empty. Name the recording, or remove the line.")
    if _URL.match(cell):
        raise CorpusError(f"{where}: `file` is the address {cell}. Download the recording, and give the file's path.")
    if cell.endswith("/") or os.path.basename(cell) in (".", ".."):
        raise CorpusError(f"{where}: `file` is the folder {cell}. Name the recording itself.")
    return cell


def _seconds(text: str, name: str, where: str) -> float:
    try:
        value = float(text or 0)
    except ValueError:
        value = -1.0
    if not 0 <= value < 1e7:
        raise CorpusError(f"{where}: `{name}` is {text!r}, not a time. Give seconds such as 12.48.")
    return value
