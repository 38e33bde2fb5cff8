"""The adapter ``mocap``: anybody's motion capture, a CSV file of named channels and a sound file per utterance."""

import os
from collections.abc import Mapping
from pathlib import Path

from visualspeech.corpora.files import VIDEOS, recording_fields, shown
from visualspeech.corpora.folder import existing_folder, of_folder, of_speaker, transcript_beside
from visualspeech.corpora.folder_table import OPTIONAL, checked_path, numbered_rows, row_fields
from visualspeech.corpora.records import Utterance, displayable

NEEDED = ("file",)
#: Files of sound, the first that is there; of a video the sound is taken.
SOUNDS = (".wav", ".flac", ".aif", ".aiff", ".m4a", ".mp3", ".aac", ".ogg", ".opus")
_NO_SOUND = "Put the sound beside the CSV under the same name, or name it in the column `audio` of the corpus's table."


def utterances(corpus: Mapping) -> list[Utterance]:
    """List the CSV files of a folder and of all folders inside it, each with its sound, sorted by file.

    Parameters
    ----------
    corpus : settings. ``root``: the folder. ``table`` (optional): a TSV or CSV file with a header line, one row per
        utterance: ``file``, the motion capture (relative to the root), and optionally ``audio``, ``transcript``,
        ``id``, ``speaker``, ``split``, ``emotion``, ``start`` and ``end`` (seconds in both files). Without a column
        ``audio``, and without a table, the sound is the sound or video file of the same name. Without a table the
        transcript is the ``.txt`` file of the same name. ``speaker`` (optional): as with the adapter ``folder``.
        ``transcripts``: whether transcripts are read; without them nothing is aligned.

    Returns
    -------
    Utterances. One without sound has a ``problem``.

    Raises
    ------
    SettingError
        ``root`` is not a folder, or ``table`` is not a file.
    CorpusError
        There is no CSV file, none of the speaker, or the table cannot be read.
    """
    root = existing_folder(corpus.get("root"), corpus)
    text = corpus.get("transcripts", True)
    found = _of_table(root, corpus, text) if corpus.get("table") else _of_files(root, text)
    return of_speaker(found, str(corpus.get("speaker") or ""), str(corpus.get("name") or root.name), root)


def _of_table(root: Path, corpus: Mapping, text: bool) -> list[Utterance]:
    listed = []
    for row, number in numbered_rows(root, corpus, NEEDED, ("audio", "transcript", *OPTIONAL)):
        motion = root / row.cells["file"]
        named = row.cells.get("audio", "")
        sound = root / checked_path(named, row.where) if named else _sound_beside(motion)
        fields = row_fields(row, number, root) | ({} if text else {"transcript": ""})
        listed.append(Utterance(**{**fields, **_files(motion, sound)}))
    return listed


def _of_files(root: Path, text: bool) -> list[Utterance]:
    return of_folder(
        root,
        {".csv"},
        lambda path: {
            **(transcript_beside(path) if text else {"transcript": ""}),
            **_files(path, _sound_beside(path)),
        },
        f"no motion capture in {shown(root)}. Put CSV files there with a sound file (such as .wav) of the same "
        "name beside each, or set `root:` to the folder that holds them.",
    )


def _files(motion: Path, sound: Path | None) -> dict[str, str]:
    """Fields of the files of an utterance; what is wrong with them."""
    fields = {"media": "", **recording_fields(motion, "motion")}
    if sound is None:
        return {"problem": f"no sound: no sound or video file named {displayable(motion.stem)} lies beside it",
                "remedy": _NO_SOUND, **fields}  # fmt: skip
    return {**recording_fields(sound, "audio"), **fields}


def _sound_beside(motion: Path) -> Path | None:
    """The sound or video file with the name of a CSV file; sound comes first."""
    endings = [ending for one in (*SOUNDS, *sorted(VIDEOS)) for ending in (one, one.upper())]
    stem = os.path.splitext(motion)[0]
    return next((Path(f"{stem}{ending}") for ending in endings if os.path.isfile(f"{stem}{ending}")), None)
