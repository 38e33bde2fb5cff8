"""File names of every kind: each recording is listed once, under a legal id of its own, and its path survives."""

import os
import random
import unicodedata
from pathlib import Path

from tests.campaign.results import Result, refused, used
from visualspeech.corpora.adapters import list_utterances
from visualspeech.corpora.records import LEGAL_ID, MAX_ID, Utterance, displayable
from visualspeech.corpora.table import read_utterances, write_utterances
from visualspeech.errors import VisualSpeechError

_AT_A_TIME = 50  # names in one corpus
_ALPHABETS = (
    "abcXYZ019", "{}[]()", "*?!~$%&;|<>", " \t\n\r", "'\"`\\", "äöüßñ", "你好再见", "مرحبا", "кот", "日本語",
    "\U0001f600\U0001f60e", "\u0301\u0308\u200b\u2028\u202e", "-._", ":=#@+,",
)  # fmt: skip
_FIXED = (
    "{shard}", "{", "}}", "{wildcards.x}", "%s", "$(id)", "`id`", "con", "nul", "-rf", "--help", "~", "~root",
    "a..b", "a.mp4.mp4", "s3:b", "http:a", "file:x", "a\\b", "a'b\"c", "a\nb", "a\tb", "\u00e9", "e\u0301", "\u212b",
    "A", "a", "ß", "ẞ", " ", "a ",
)  # fmt: skip


def run(folder: Path, seed: int, count: int) -> list[Result]:
    """Results of file names, fifty in each corpus."""
    results = []
    for first in range(0, count, _AT_A_TIME):
        rng = random.Random(f"names {seed} {first}")
        root = folder / f"names{first}"
        root.mkdir()
        written = {_write(root, rng) for _ in range(min(_AT_A_TIME, count - first))}
        results += _listed(root, sorted(written))
    return results


def _write(root: Path, rng: random.Random) -> bytes:
    """Write an empty recording with a transcript; returns its path as bytes."""
    name = os.fsencode(_name(rng))
    if rng.random() < 0.1:
        name = bytes(rng.choice(b"\xe9\xff\x80a1") for _ in range(5))  # no valid UTF-8, mostly
    inside = os.fsencode(rng.choice(["", "", "s1", "Dr. No", "{x}", "你好", "a/b/c/d", "long" * 40]))
    folder = os.path.join(os.fsencode(root), inside)
    os.makedirs(folder, exist_ok=True)
    path = os.path.join(folder, name[:240] + b".mp4")
    with open(path, "wb") as file:
        file.write(b"x")
    with open(path[:-4] + b".txt", "wb") as file:
        file.write(b"hello there")
    return path


def _name(rng: random.Random) -> str:
    if rng.random() < 0.4:
        return rng.choice(_FIXED)
    letters = rng.choice(_ALPHABETS) + rng.choice(_ALPHABETS)
    name = "".join(rng.choice(letters) for _ in range(rng.choice([1, 3, 12, 50])))
    return name.encode()[:230].decode(errors="ignore").lstrip(".") or "a"


def _listed(root: Path, written: list[bytes]) -> list[Result]:
    """Whether a corpus lists each of the files, and the table of utterances gives them back."""
    corpus = {"name": "names", "adapter": "folder", "root": str(root)}
    try:
        utterances = list_utterances(corpus)
    except VisualSpeechError as error:
        colliding = _same_for_people(written)
        said = str(error)
        if colliding and "two utterances have one id" in said:
            # Names that differ only in case or normalisation are refused; without them the others are planned.
            for path in colliding:
                os.remove(path)
            rest = [path for path in written if path not in colliding]
            return [refused(repr(path), said, [str(root)]) for path in colliding] + _listed(root, rest)
        return [Result(f"{len(written)} names", True, said, "a corpus was refused for its names: " + said[:300])]
    table = root.parent / f"{root.name}.tsv"
    write_utterances(table, (vars(one) for one in utterances))
    again = {one.id: one for one in read_utterances(table)}
    results = [_result(one, again.get(one.id), written) for one in utterances]
    if len(utterances) != len(written):
        results.append(used(f"{len(written)} names", wrong=_unlisted(utterances, written)))
    return results


def _unlisted(utterances: list[Utterance], written: list[bytes]) -> str:
    listed = {one.media for one in utterances}
    missing = [path for path in written if displayable(os.fsdecode(path)) not in listed]
    return f"{len(utterances)} of {len(written)} names are listed, not {missing}"


def _same_for_people(written: list[bytes]) -> list[bytes]:
    """Paths that another path equals but for case and normalisation."""
    folded: dict[str, list[bytes]] = {}
    for path in written:
        text = unicodedata.normalize("NFC", os.fsdecode(path)).lower()
        folded.setdefault(text, []).append(path)
    return [path for paths in folded.values() if len(paths) > 1 for path in paths]


def _result(one: Utterance, again: Utterance | None, written: list[bytes]) -> Result:
    case = repr(one.media)
    if not LEGAL_ID.fullmatch(one.id) or len(one.id) > MAX_ID:
        return used(case, wrong=f"the id {one.id!r} is no legal one")
    if again is None or again.media != one.media:
        return used(case, wrong=f"the table of utterances gives {again} back")
    if one.problem:
        return refused(case, f"{one.media}: {one.problem}", [one.media])
    found = os.path.isfile(one.media) and os.fsencode(one.media) in written
    return used(case, wrong="" if found else "its path is lost")
