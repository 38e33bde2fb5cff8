"""Texts of the IEMOCAP corpus: the emotions that raters gave the turns of a dialog, and their transcripts."""

import re
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

from visualspeech.corpora.files import one_line
from visualspeech.storage.foreign import read_bytes

#: Labels that the corpus gives a turn itself, written out as its raters' are; ``xxx`` says that they did not agree.
LABELS = {
    "ang": "anger", "dis": "disgust", "exc": "excited", "fea": "fear", "fru": "frustration", "hap": "happiness",
    "neu": "neutral", "oth": "other", "sad": "sadness", "sur": "surprise", "xxx": "",
}  # fmt: skip
_EVALUATED = re.compile(r"\[\s*[\d.]+\s*-\s*[\d.]+\s*\]\s+(\S+)\s+(\S+)\s+\[")
#: Categories by a rater (``C-E2``); evaluations by the actors themselves (``C-F1``) are left out, as in the corpus.
_RATER = re.compile(r"C-E\d*:\s*([^()]*)")
_SAID = re.compile(r"(Ses\d\d[FM]_\S+)\s+\[[^\]]*\]:\s*(.*)", re.IGNORECASE)
_NOISE = re.compile(r"\[[^\]]*\]")  # such as [LAUGHTER]


def read_emotions(path: str | Path) -> dict[str, str]:
    """Turn -> emotion, from a file of ``dialog/EmoEvaluation``; empty where most raters do not agree.

    A line ``[6.2901 - 8.2357] <tab> Ses01F_impro01_F000 <tab> neu <tab> [2.5, 2.5, 2.5]`` begins a turn; lines of its
    raters follow, ``C-E2: <tab> Neutral; <tab> ()``. See :func:`majority`. Where a turn has no lines of raters, the
    label of its first line counts.

    Raises
    ------
    OSError
        The file cannot be read.
    """
    labels: dict[str, str] = {}
    raters: dict[str, list[set[str]]] = {}
    turn = ""
    for line in _lines(path):
        begun = _EVALUATED.match(line)
        if begun:
            turn = begun[1]
            labels[turn], raters[turn] = LABELS.get(begun[2].lower(), begun[2].lower()), []
            continue
        rated = _RATER.match(line)
        if rated and turn:
            chosen = {one.strip().lower() for one in rated[1].split(";")} - {""}
            raters[turn] += [chosen] if chosen else []
    return {turn: majority(raters[turn]) if raters[turn] else label for turn, label in labels.items()}


def majority(raters: Iterable[set[str]]) -> str:
    """The emotion that more than half of the raters of a turn chose; empty if there is none, or more than one.

    A rater may choose several emotions; each counts as one choice of that rater (Busso et al., 2008, section 5.2).
    """
    raters = list(raters)
    counts = Counter(emotion for chosen in raters for emotion in chosen)
    most = [emotion for emotion, count in counts.items() if 2 * count > len(raters) and count == max(counts.values())]
    return most[0] if len(most) == 1 else ""


def read_transcripts(path: str | Path) -> dict[str, str]:
    """Turn -> what is said, from a file of ``dialog/transcriptions``; noises such as ``[LAUGHTER]`` are left out.

    Raises
    ------
    OSError
        The file cannot be read.
    """
    found = (_SAID.match(line) for line in _lines(path))
    return {match[1]: one_line(_NOISE.sub(" ", match[2])) for match in found if match}


def _lines(path: str | Path) -> list[str]:
    return [line.strip() for line in read_bytes(path).decode("utf-8", "replace").splitlines()]
