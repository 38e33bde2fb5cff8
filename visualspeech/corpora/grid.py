"""The adapter ``grid``: the GRID corpus (Cooke, Barker, Cunningham and Shao, 2006), sentences of six words each.

Copies of the corpus differ in their folders. All videos and ``.align`` files below the root are found wherever they
are; the speaker is the nearest enclosing folder named ``s1`` ... ``s34``.
"""

import os
import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from visualspeech.corpora.files import VIDEOS, find_files, recording_fields, shown, unreadable_folders
from visualspeech.corpora.folder import existing_folder
from visualspeech.corpora.records import Utterance, displayable, legal_id
from visualspeech.errors import CorpusError
from visualspeech.storage.foreign import read_bytes

UNITS_PER_SECOND = 25_000  # of the times in an .align file
SILENCES = frozenset({"sil", "sp"})
SPOKEN = {"z": "zed"}  # British English
_RESTORE = "Restore it from the corpus, or remove it to have the transcript read from the recording's name."
_SPEAKER = re.compile(r"s(\d{1,2})(?![\da-z])", re.IGNORECASE)
_CODE = re.compile(r"[bpls][bgrw][abiw][a-z][1-9z][anps]")
_WORDS = (
    {"b": "bin", "l": "lay", "p": "place", "s": "set"},
    {"b": "blue", "g": "green", "r": "red", "w": "white"},
    {"a": "at", "b": "by", "i": "in", "w": "with"},
    {},
    dict(zip("123456789z", "one two three four five six seven eight nine zero".split(), strict=True)),
    {"a": "again", "n": "now", "p": "please", "s": "soon"},
)


def utterances(corpus: Mapping) -> list[Utterance]:
    """List the recordings of one or all speakers of GRID, sorted by id.

    Parameters
    ----------
    corpus : settings. ``root`` (if empty, the environment variable ``GRID_ROOT``): a folder of GRID. ``speaker``
        (optional): such as ``s1``; by default all speakers. With several speakers, ids begin with their names.

    Returns
    -------
    Utterances whose transcript is read from the ``.align`` file or, if there is none, from the sentence code in the
    file name ("bbaf2n": bin blue at f two now). The letter z is written "zed". An utterance whose ``.align`` file
    cannot be read has a ``problem``, which the check of the recordings reports.

    Raises
    ------
    SettingError
        The root is not set or does not exist.
    CorpusError
        There are no recordings, or none of the speaker.
    """
    root = existing_folder(
        corpus.get("root") or os.environ.get("GRID_ROOT"), corpus, ", or the environment variable GRID_ROOT to it"
    )
    found = find_files(root, VIDEOS)
    videos = [(speaker_of(path, root), path) for path in found.files]
    blocked = list(unreadable_folders(found, root, speaker_of))
    if not videos and not blocked:
        raise CorpusError(
            f"no recordings in {shown(root)}. Set `root:` or GRID_ROOT to the folder that holds GRID's videos "
            "(s1/bbaf2n.mpg and so on); archives must be unpacked first."
        )
    wanted = str(corpus.get("speaker") or "")
    speakers = sorted({speaker for speaker, _ in videos})
    if wanted and speakers not in ([], [""]):
        videos = [(speaker, path) for speaker, path in videos if speaker == wanted.lower()]
        blocked = [one for one in blocked if one.speaker == wanted.lower()]
        if not videos:
            raise CorpusError(
                f"no recordings of the speaker {wanted!r} in {shown(root)}; there are "
                f"{', '.join(name or 'recordings without a speaker folder' for name in speakers)}. "
                "Set `speaker:` to one of them."
            )
    alone = len({speaker for speaker, _ in videos}) == 1
    alignments = find_files(root, {".align"}).files
    aligned = {(speaker_of(path, root), path.stem.lower()): path for path in alignments}
    listed = [
        Utterance(
            id=legal_id(path.stem if alone else f"{speaker or 'unknown'}-{path.stem}"),
            speaker=speaker or wanted or "grid",
            **{**_transcript(path.stem.lower(), speaker, aligned), **recording_fields(path)},
        )
        for speaker, path in sorted(videos)
    ]
    return listed + [replace(one, speaker=one.speaker or wanted or "grid") for one in blocked]


def speaker_of(path: Path, root: Path) -> str:
    """Speaker of a file: the nearest enclosing folder named after one, up to and including the root; empty if none."""
    inside = path.relative_to(root).parent.parts
    for folder in (*reversed(inside), root.absolute().name):
        match = _SPEAKER.match(folder)
        if match:
            return f"s{int(match[1])}"
    return ""


def read_alignment(path: str | Path) -> list[tuple[str, float, float]]:
    """GRID's own alignment of a sentence: (word as written, start, end) in seconds, silences included.

    Raises
    ------
    CorpusError
        The file cannot be read, or does not hold lines of ``start end word``.
    """
    try:
        lines = [line.split() for line in read_bytes(path).decode("utf-8", "replace").splitlines()]
        return [
            (word, int(start) / UNITS_PER_SECOND, int(end) / UNITS_PER_SECOND)
            for start, end, word in filter(None, lines)
        ]
    except OSError as error:
        raise CorpusError(f"{displayable(str(path))} cannot be read: {error.strerror or error}. {_RESTORE}") from error
    except ValueError as error:
        raise CorpusError(
            f"{displayable(str(path))} is no alignment of GRID (lines of `start end word`). {_RESTORE}"
        ) from error


def transcript_of_code(code: str) -> str:
    """The sentence encoded in a GRID file name; empty if the name is not such a code."""
    if not _CODE.fullmatch(code):
        return ""
    return " ".join(
        SPOKEN.get(letter, letter) if not words else words[letter] for words, letter in zip(_WORDS, code, strict=True)
    )


def _transcript(code: str, speaker: str, aligned: Mapping[tuple[str, str], Path]) -> dict[str, str]:
    """Transcript of a recording; what is wrong with its alignment, where that cannot be read."""
    path = aligned.get((speaker, code)) or aligned.get(("", code))
    if path is None:
        return {"transcript": transcript_of_code(code)}
    try:
        words = [word for word, _, _ in read_alignment(path)]
    except CorpusError as error:
        return {"transcript": "", "problem": str(error).removesuffix(f". {_RESTORE}"), "remedy": _RESTORE}
    return {"transcript": " ".join(SPOKEN.get(word, word) for word in words if word not in SILENCES)}
