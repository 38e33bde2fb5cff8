"""Tables: TSV files."""

import csv
import io
from collections.abc import Collection
from pathlib import Path

import numpy as np

from visualspeech.errors import DamagedFile, plain_reason
from visualspeech.storage.files import write_text


def table_text(table) -> str:
    """A data frame as TSV text (floats with the shortest digits that read back equal, no index)."""
    return table.to_csv(sep="\t", index=False, lineterminator="\n")


def write_table(path: str | Path, table) -> None:
    """Write a :class:`pandas.DataFrame` as TSV, atomically."""
    write_text(path, table_text(table))


def read_table(
    path: str | Path,
    text_columns: Collection[str] = ("id",),
    number_columns: Collection[str] | None = (),
    required: Collection[str] = (),
    edited: bool = False,
):
    """Read a TSV written by :func:`write_table`.

    Empty cells of text columns become empty strings, those of other columns NaN. Words such as "null" and "NA" are
    read as text, not as missing values.

    Parameters
    ----------
    text_columns : stay text even where they look like numbers
    number_columns : must hold numbers or nothing; None: all that are no text columns. Columns of neither kind are
        numbers if all of their cells are
    required : columns that the table must have, beside the number columns
    edited : whether people edit the table: blank lines, and a last line without its end, are then no damage, and the
        advice is not to delete it

    Raises
    ------
    StorageError
        The file is missing or no table, a column is missing, or a row has too many or too few cells or a text where a
        number is expected; the message names the line.
    """
    try:
        return _read(path, text_columns, number_columns, required, edited)
    except DamagedFile as error:
        if not edited:
            raise
        raise DamagedFile(path, error.reason, "Correct the file and run the same command again.") from error


def read_numbers(path: str | Path, required: Collection[str] = ()):
    """Read a TSV as :func:`read_table`; all columns but ``id`` must hold numbers or nothing."""
    return read_table(path, number_columns=None, required=required)


def _read(path, text_columns, number_columns, required, edited):
    import pandas

    try:
        text = Path(path).read_bytes().decode("utf-8-sig" if edited else "utf-8")
        lines = _row_lines(path, text, edited)
        options = {"sep": "\t", "dtype": {name: str for name in text_columns}, "keep_default_na": False}
        table = pandas.read_csv(io.StringIO(text), index_col=False, **options)
    except (OSError, ValueError, csv.Error) as error:
        raise DamagedFile(path, f"it is no table ({plain_reason(error)})") from error
    if number_columns is None:
        number_columns = [name for name in table.columns if name not in text_columns]
    for name in (*required, *number_columns):
        if name not in table.columns:
            raise DamagedFile(path, f"it has no column {name}")
    table = _numbers_where_possible(table, text_columns)
    for name in number_columns:
        _check_numbers(path, table[name], lines)
    return table


def _row_lines(path, text: str, edited: bool) -> list[int]:
    """The line in which each row of a table ends; refuses rows that have other numbers of cells than the head."""
    if text and not edited and not text.endswith("\n"):
        raise DamagedFile(path, f"it breaks off in line {text.count(chr(10)) + 1}")
    reader = csv.reader(io.StringIO(text, newline=""), delimiter="\t", strict=True)
    width, lines = None, []
    for cells in reader:
        if not cells and edited:
            continue
        width = len(cells) if width is None else width
        if len(cells) != width:
            raise DamagedFile(path, f"line {reader.line_num} has {len(cells)} cells, the head of the table {width}")
        lines.append(reader.line_num)
    return lines[1:]


def _check_numbers(path, column, lines: list[int]) -> None:
    import pandas

    if pandas.api.types.is_numeric_dtype(column):
        return
    bad = pandas.to_numeric(column.replace("", np.nan), errors="coerce").isna() & (column.astype(str) != "")
    at = int(np.flatnonzero(bad)[0])
    raise DamagedFile(
        path, f"line {lines[at]} has {str(column.iloc[at])[:40]!r} in the column {column.name}, no number"
    )


def _numbers_where_possible(table, text_columns):
    import pandas

    converted = {}
    for name in table.columns:
        if name in text_columns or pandas.api.types.is_numeric_dtype(table[name]):
            continue
        column = table[name].replace("", np.nan)
        try:
            converted[name] = pandas.to_numeric(column)
        except (ValueError, TypeError):
            continue
    return table.assign(**converted)
