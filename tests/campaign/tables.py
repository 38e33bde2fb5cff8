"""Tables of utterances: what a program wrote is read back whole, and what is damaged is refused by file and line."""

import csv
import io
import random
from pathlib import Path

from tests.campaign.results import Result, refused, used
from visualspeech.corpora.adapters import list_utterances
from visualspeech.errors import VisualSpeechError

_WORDS = (
    "hello",
    "Yes,",
    "no;",
    '"quoted"',
    "it's",
    "a\u2028b",
    "c\x0bd",
    "e\x0cf",
    "g\x85h",
    "naïve",
    "你好",
    "-",
    "=1+1",
    "NA",
    "null",
)
_SUFFIXES = {"\t": ".tsv", ",": ".csv", ";": ".csv"}


def run(folder: Path, seed: int, count: int) -> list[Result]:
    """Results of tables, half of them as a program writes them and half damaged in a way that loses content."""
    root = folder / "tables"
    root.mkdir()
    results = []
    for number in range(count):
        rng = random.Random(f"tables {seed} {number}")
        rows = [(f"clip{row}.mp4", _transcript(rng), f"id{row}") for row in range(rng.randrange(1, 8))]
        results.append((_whole if number % 2 else _damaged)(root, f"table{number}", rows, rng))
    return results


def _transcript(rng: random.Random) -> str:
    return " ".join(rng.choice(_WORDS) for _ in range(rng.randrange(1, 6)))


def _whole(root: Path, name: str, rows: list[tuple[str, ...]], rng: random.Random) -> Result:
    """A table as spreadsheets write it, in any of their dialects and encodings."""
    delimiter = rng.choice(list(_SUFFIXES))
    ending, encoding = rng.choice(["\n", "\r\n", "\r"]), rng.choice(["utf-8", "utf-8-sig", "utf-16"])
    if delimiter == "\t":
        text = ending.join("\t".join(row) for row in [("file", "transcript", "id"), *rows]) + ending
    else:
        broken = rng.random() < 0.3
        rows = [(file, said.replace(" ", "\n", 1) if broken else said, one) for file, said, one in rows]
        out = io.StringIO(newline="")
        # Python's writer leaves a line feed unquoted where lines end otherwise.
        quoting = csv.QUOTE_ALL if broken else rng.choice([csv.QUOTE_MINIMAL, csv.QUOTE_ALL])
        writer = csv.writer(out, delimiter=delimiter, lineterminator=ending, quoting=quoting)
        writer.writerows([("file", "transcript", "id"), *rows])
        text = out.getvalue()
    path = root / f"{name}{_SUFFIXES[delimiter]}"
    path.write_bytes(text.encode(encoding))
    case = f"a whole table, {delimiter!r} {ending!r} {encoding}: {rows!r}"
    try:
        found = {one.id: one.transcript for one in _listed(root, path)}
    except VisualSpeechError as error:
        return Result(case, True, str(error), f"a whole table was refused: {error}")
    expected = {one: " ".join(said.split()) for _, said, one in rows}
    return used(case, wrong="" if found == expected else f"read {found}, written {expected}")


def _damaged(root: Path, name: str, rows: list[tuple[str, ...]], rng: random.Random) -> Result:
    """A table in which content would be lost or moved if it were read all the same."""
    lines = [",".join(("file", "transcript", "id")), *(f"{file},plain words,{one}" for file, _, one in rows)]
    at = rng.randrange(1, len(lines))
    file, _, one = rows[at - 1]
    damages = {
        "an unquoted comma": f"{file},plain, words,{one}",
        "an unclosed quote": f'{file},"plain words,{one}',
        "a quote inside": f'{file},"plain "words",{one}',
        "a time that is none": f"{file},plain words,{one},soon",
        "a double id": f"{file},plain words,{one}\nother{file},plain words,{one}",
        "an illegal id": f"{file},plain words,a/{one}",
        "no file": f",plain words,{one}",
        "an endless id": f"{file},plain words,{'i' * 300}",
        "an address as file": f"http://127.0.0.1:9/{file},plain words,{one}",
        "a folder as file": f".,plain words,{one}",
        "an endless cell": f"{file},{'word ' * 40_000},{one}",
        "an unknown split": f"{file},plain words,{one},,sometimes",
    }
    what = rng.choice(list(damages))
    if what in ("a time that is none", "an unknown split"):
        lines[0] += ",start" + ",split" * (what == "an unknown split")
    lines[at] = damages[what]
    path = root / f"{name}.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    case = f"a table with {what}"
    try:
        _listed(root, path)
    except VisualSpeechError as error:
        return refused(case, str(error), [path.name, file, one])
    except Exception as error:  # what this campaign looks for
        return Result(case, True, repr(error), f"raised {error!r}")
    return used(case, wrong="the damage was not noticed")


def _listed(root: Path, path: Path) -> list:
    return list_utterances({"name": "tables", "adapter": "folder", "root": str(root), "table": path.name})
