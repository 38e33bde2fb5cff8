"""The list of what an evaluated viewing test shows, by which the report finds it."""

from pathlib import Path

from visualspeech.storage.tables import read_table

#: File of an evaluation: columns ``kind`` (title, page, table or figure), ``file``, ``text``.
CONTENTS = "contents.tsv"
COLUMNS = ("kind", "file", "text")


def read_contents(folder: str | Path) -> list[tuple[str, str, str]]:
    """The rows of the list in the folder of an evaluation; raises StorageError where it is missing or damaged."""
    table = read_table(Path(folder, CONTENTS), COLUMNS, required=COLUMNS)
    return list(table[list(COLUMNS)].itertuples(index=False, name=None))
