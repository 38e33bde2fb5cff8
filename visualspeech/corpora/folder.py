"""The adapter ``folder``: recordings in a folder, with a ``.txt`` transcript beside each or one table for all."""

import os
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from pathlib import Path

from visualspeech.corpora.files import (
    VIDEOS,
    find_files,
    read_transcript,
    recording_fields,
    shown,
    speaker_folder,
    unreadable_folders,
)
from visualspeech.corpora.folder_table import table_utterances
from visualspeech.corpora.records import Utterance, displayable, legal_id
from visualspeech.errors import CorpusError, SettingError


def utterances(corpus: Mapping) -> list[Utterance]:
    """List the recordings of a folder and of all folders inside it, sorted by file.

    Parameters
    ----------
    corpus : settings. ``root``: the folder. ``table`` (optional): a TSV or CSV file with a header line, inside or
        outside the root, one row per utterance: ``file`` (relative to the root), ``transcript`` and optionally ``id``,
        ``speaker``, ``split``, ``emotion``, ``start`` and ``end`` (seconds). Without a table the transcript of a video
        is the ``.txt`` file of the same name. The speaker is that of the table, or the name of the recording's folder.
        ``speaker`` (optional): use the recordings of this speaker only; if recordings have no speaker, their speaker.

    Returns
    -------
    Utterances. A missing transcript is empty; the check of the recordings rejects it, as it does an utterance with a
    ``problem``: a transcript that cannot be read, a file name that is not UTF-8, a folder that cannot be listed.

    Raises
    ------
    SettingError
        ``root`` is not a folder, or ``table`` is not a file.
    CorpusError
        There is no recording, none of the speaker, or the table cannot be read.
    """
    root = existing_folder(corpus.get("root"), corpus)
    found = table_utterances(root, corpus) if corpus.get("table") else _of_files(root)
    return of_speaker(found, str(corpus.get("speaker") or ""), str(corpus.get("name") or root.name), root)


def of_speaker(utterances: list[Utterance], wanted: str, name: str, root: Path) -> list[Utterance]:
    """The utterances of one speaker, or of all; recordings without a speaker get the wanted one, else ``name``."""
    speakers = sorted({one.speaker for one in utterances if not one.problem})
    if wanted and speakers not in ([], [""]):
        utterances = [one for one in utterances if one.speaker == wanted]
        if not utterances:
            raise CorpusError(
                f"no recordings of the speaker {wanted!r} in {shown(root)}; there are "
                f"{', '.join(one or 'recordings without a speaker' for one in speakers)}. Set `speaker` to one of them."
            )
    return [replace(one, speaker=one.speaker or wanted or name) for one in utterances]


def existing_folder(root: str | os.PathLike | None, corpus: Mapping, also: str = "") -> Path:
    """The root folder of a corpus.

    Parameters
    ----------
    corpus : settings, for the name in messages
    also : other ways to give the root, for messages

    Raises
    ------
    SettingError
        It is not set, or there is no such folder.
    """
    name = corpus.get("name", "?")
    if not root:
        raise SettingError(f"the corpus {name!r} has no `root`. Set `root:` to the folder of its recordings{also}.")
    path = Path(os.path.expanduser(root))
    if not os.path.isdir(path):
        what = "is a file, not a folder" if os.path.isfile(path) else "does not exist"
        raise SettingError(
            f"the root of the corpus {name!r} {what}: {shown(path)}. Set `root:` to the folder of its "
            f"recordings{also}; a relative path is relative to the folder in which snakemake runs."
        )
    return path


def _of_files(root: Path) -> list[Utterance]:
    return of_folder(
        root,
        VIDEOS,
        lambda video: {**transcript_beside(video), **recording_fields(video)},
        f"no recordings in {shown(root)}. Put videos (such as .mp4, .mov, .mkv, .avi, .mpg) there with a .txt "
        "transcript of the same name beside each, or set `root:` to the folder that holds them.",
    )


def of_folder(root: Path, endings: Collection[str], fields: Callable[[Path], Mapping], nothing: str) -> list[Utterance]:
    """One utterance per file with one of some endings in a folder and all folders inside it, sorted by file.

    Parameters
    ----------
    fields : of the utterance of a file, without id and speaker
    nothing : message where there is no such file

    Raises
    ------
    CorpusError
        There is no such file, and every folder could be listed.
    """
    found = find_files(root, endings)
    if not found.files and not found.unreadable:
        raise CorpusError(nothing)
    listed = [
        Utterance(
            id=legal_id("-".join(path.relative_to(root).with_suffix("").parts)),
            speaker=displayable(speaker_folder(path, root)),
            **fields(path),
        )
        for path in found.files
    ]
    return listed + list(unreadable_folders(found, root, speaker_folder))


def transcript_beside(video: Path) -> dict[str, str]:
    """Transcript of a recording from the file beside it; what is wrong with that file, where it cannot be read."""
    for ending in (".txt", ".TXT"):
        path = f"{os.path.splitext(video)[0]}{ending}"
        try:
            return {"transcript": read_transcript(path)}
        except OSError as error:
            if isinstance(error, FileNotFoundError) and not os.path.islink(path):
                continue
            return {
                "transcript": "",
                "problem": f"the transcript {displayable(os.path.basename(path))} cannot be read: "
                f"{error.strerror or error}",
                "remedy": "Write what is said into a text file of that name, and give yourself the right to read it.",
            }
    return {"transcript": ""}
