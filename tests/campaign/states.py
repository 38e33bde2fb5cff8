"""Damaged files of a run: each is read as it was written, or refused by name with the advice to make it anew."""

import random
from collections.abc import Callable
from pathlib import Path

import numpy as np

from tests.campaign.results import Result, refused, used
from visualspeech.corpora.findings import Finding, read_findings, write_findings
from visualspeech.corpora.records import Utterance
from visualspeech.corpora.table import read_utterances, write_utterances
from visualspeech.errors import VisualSpeechError
from visualspeech.speech.alignment import Alignment, Segment, read_alignments, to_table
from visualspeech.storage.arrays import ArrayReader, ArrayWriter
from visualspeech.storage.models import read_model, write_model
from visualspeech.storage.tables import write_table


def run(folder: Path, seed: int, count: int) -> list[Result]:
    """Results of damaged files of every format."""
    folder = folder / "states"
    folder.mkdir()
    kinds: list[tuple[Path, Callable]] = [
        (_alignment(folder / "alignment.tsv"), read_alignments),
        (_arrays(folder / "arrays.h5"), _all_arrays),
        (_model(folder / "model.safetensors"), read_model),
        (_utterances(folder / "utterances.tsv"), read_utterances),
        (_findings(folder / "findings.tsv"), read_findings),
    ]
    results = []
    for number in range(count):
        rng = random.Random(f"states {seed} {number}")
        path, read = kinds[number % len(kinds)]
        results.append(_damaged(path, read, rng))
    return results


def _damaged(path: Path, read: Callable, rng: random.Random) -> Result:
    whole = path.read_bytes()
    expected = read(path)
    data, what = _damage(whole, path.suffix == ".tsv", rng)
    case = f"{path.name}: {what}"
    path.write_bytes(data)
    try:
        found = read(path)
    except VisualSpeechError as error:
        return refused(case, str(error), [str(path)])
    except Exception as error:  # what this campaign looks for
        return Result(case, True, repr(error), f"raised {error!r}")
    finally:
        path.write_bytes(whole)
    # In a table no checksum guards the text itself; what must be noticed is that rows or cells are lost.
    same = _same(found, expected) if path.suffix != ".tsv" else len(found) == len(expected)
    return used(case, wrong="" if same else "read as something else")


def _damage(data: bytes, text: bool, rng: random.Random) -> tuple[bytes, str]:
    at = rng.randrange(len(data))
    ways = {
        "is whole": lambda: data,
        "ends early": lambda: data[:at],
        "is empty": lambda: b"",
        "lost some bytes": lambda: data[:at] + data[at + rng.choice([1, 8, 500]) :],
        "has a hole of zeros": lambda: data[:at] + bytes(min(64, len(data) - at)) + data[at + 64 :],
        "has a changed byte": lambda: data[:at] + bytes([data[at] ^ (1 << rng.randrange(8))]) + data[at + 1 :],
        "has a changed block": lambda: data[:at] + rng.randbytes(min(16, len(data) - at)) + data[at + 16 :],
    }
    if text:
        lines = data.decode().splitlines(keepends=True)
        line = rng.randrange(1, len(lines))
        cells = lines[line].rstrip("\n").split("\t")
        cell = rng.randrange(len(cells))
        ways = {
            "is whole": lambda: data,
            "lost a cell": lambda: _row(lines, line, cells[:cell] + cells[cell + 1 :]),
            "has a cell more": lambda: _row(lines, line, [*cells, "x"]),
            "lost the end of a row": lambda: _row(lines, line, cells[: cell or 1]),
            "is cut within a row": lambda: "".join(lines[:line]).encode() + lines[line].encode()[:3],
            "has a row of nonsense": lambda: _row(lines, line, ["nonsense"]),
            "is not UTF-8": lambda: data[:at] + b"\xff\xfe\xe9" + data[at:],
            "is empty": lambda: b"",
        }
    what = rng.choice(list(ways))
    return ways[what](), what


def _row(lines: list[str], number: int, cells: list[str]) -> bytes:
    return "".join([*lines[:number], "\t".join(cells) + "\n", *lines[number + 1 :]]).encode()


def _alignment(path: Path) -> Path:
    states = tuple(Segment(str(1 + k % 3), k / 10, (k + 1) / 10, k // 3) for k in range(9))
    phones = tuple(Segment(label, k * 0.3, (k + 1) * 0.3, k) for k, label in enumerate(("sil", "AA", "sil")))
    words = tuple(Segment(label, k * 0.3, (k + 1) * 0.3) for k, label in enumerate(("sil", "ah", "sil")))
    states = tuple(Segment(one.label, round(one.start, 5), round(one.end, 5), one.parent) for one in states)
    write_table(path, to_table({f"u{k}": Alignment(words, phones, states) for k in range(4)}))
    return path


def _arrays(path: Path) -> Path:
    rng = np.random.default_rng(1)
    with ArrayWriter(path) as out:
        for k in range(3):
            arrays = {
                "points": rng.normal(size=(20, 68, 2)).astype(np.float32),
                "texture": np.arange(900, dtype=np.uint8),
            }
            out.add(f"u{k}", {**arrays, "flag": np.array([True, False])}, 25.0, {"points": "px"}, width=320)
    return path


def _all_arrays(path: Path) -> dict:
    with ArrayReader(path) as arrays:
        return {one: (arrays[one], arrays.attributes(one)) for one in arrays.ids}


def _model(path: Path) -> Path:
    write_model(path, {"w": np.linspace(0, 1, 300, dtype=np.float32).reshape(20, 15)}, {"kind": "model", "rate": 25})
    return path


def _utterances(path: Path) -> Path:
    write_utterances(path, (vars(Utterance(f"u{k}", "s", f"/v/u{k}.mp4", "some words", start=0.5)) for k in range(5)))
    return path


def _findings(path: Path) -> Path:
    write_findings(path, [Finding(f"u{k}", "check", "reject", f"u{k}.mp4", "is bad", "Mend it.") for k in range(4)])
    return path


def _same(found, expected) -> bool:
    if isinstance(expected, np.ndarray):
        return found.dtype == expected.dtype and np.array_equal(found, expected)
    if isinstance(expected, dict):
        return found.keys() == expected.keys() and all(_same(found[key], expected[key]) for key in expected)
    if isinstance(expected, tuple | list):
        return len(found) == len(expected) and all(map(_same, found, expected))
    return bool(np.all(found == expected))
