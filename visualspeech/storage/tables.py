"""Tables: TSV files."""

from pathlib import Path

import numpy as np

from visualspeech.errors import StorageError
from visualspeech.storage.files import write_text


def table_text(table) -> str:
    """A data frame as TSV text (floats with the shortest digits that read back equal, no index)."""
    return table.to_csv(sep="\t", index=False, lineterminator="\n")


def write_table(path: str | Path, table) -> None:
    """Write a :class:`pandas.DataFrame` as TSV, atomically."""
    write_text(path, table_text(table))


def read_table(path: str | Path, text_columns: tuple[str, ...] = ("id",)):
    """Read a TSV written by :func:`write_table`; ``text_columns`` stay text even where they look like numbers.

    Empty cells of text columns become empty strings, those of other columns NaN. Words such as "null" and "NA" are
    read as text, not as missing values. Raises :class:`StorageError` for a missing or damaged file.
    """
    import pandas

    try:
        return pandas.read_csv(
            path,
            sep="\t",
            dtype={name: str for name in text_columns},
            keep_default_na=False,
        ).pipe(_numbers_where_possible, text_columns)
    except (OSError, ValueError) as error:
        raise StorageError(f"cannot read the table {path}: {error}. Delete it and run the command again.") from error


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
