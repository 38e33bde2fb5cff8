"""Tables of utterances: those that a corpus lists, their split, and the accepted ones."""

from collections.abc import Iterable, Mapping
from dataclasses import asdict, fields

from visualspeech.corpora.records import Utterance
from visualspeech.storage.tables import read_table, write_table

TEXT = ("id", "speaker", "media", "transcript", "split", "emotion", "audio", "motion", "problem", "remedy",
        "warning")  # fmt: skip
#: Columns that a table has only where an utterance of it has a problem or a warning.
OF_PROBLEM = ("problem", "remedy", "warning")


def read_utterances(path) -> list[Utterance]:
    """The utterances of a table, in its order; columns that are not fields of :class:`Utterance` are ignored."""
    table = read_table(path, TEXT, ("start", "end"), TEXT[:4])
    known = [field.name for field in fields(Utterance) if field.name in table.columns]
    return [Utterance(**row) for row in table[known].to_dict("records")]


def write_utterances(path, rows: Iterable[Mapping]) -> None:
    """Write utterances given as mappings, without their split."""
    import pandas

    rows = [dict(row) for row in rows]
    left_out = ["split", *(name for name in OF_PROBLEM if not any(row.get(name) for row in rows))]
    columns = [field.name for field in fields(Utterance) if field.name not in left_out]
    write_table(path, pandas.DataFrame(rows, columns=columns))


def write_split(path, split: Mapping[str, str]) -> None:
    """Write the split of each utterance, sorted by id."""
    import pandas

    write_table(path, pandas.DataFrame(sorted(split.items()), columns=["id", "split"]))


def read_split(path) -> dict[str, str]:
    """Split of each utterance: id -> train, validation or test."""
    table = read_table(path, ("id", "split"), required=("id", "split"))
    return dict(zip(table["id"], table["split"], strict=True))


def write_accepted(path, utterances: Iterable[Utterance], split: Mapping[str, str]) -> None:
    """Write the accepted utterances, each with its split, sorted by id."""
    import pandas

    rows = [{**asdict(one), "split": split[one.id]} for one in sorted(utterances, key=lambda one: one.id)]
    columns = [field.name for field in fields(Utterance) if field.name not in OF_PROBLEM]
    write_table(path, pandas.DataFrame(rows, columns=columns))


def of_split(utterances: Iterable[Utterance], split: str) -> list[Utterance]:
    """The utterances of one split, in their order."""
    return [one for one in utterances if one.split == split]
