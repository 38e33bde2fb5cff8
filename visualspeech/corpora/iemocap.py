"""The adapter ``iemocap``: the IEMOCAP corpus (Busso et al., 2008) as it is released.

Of each session it reads the sentence-level motion capture (``sentences/MOCAP_rotated``) and sound (``sentences/wav``),
the emotion of each turn (``dialog/EmoEvaluation``) and, where they are there, the transcripts
(``dialog/transcriptions``). One actor of a recording wears markers, the one that its name gives: of ``Ses01F_impro01``
the turns ``Ses01F_impro01_F000`` and so on. Turns of the other actor are not listed.
"""

import re
from collections.abc import Mapping
from pathlib import Path

from visualspeech.corpora.files import find_files, recording_fields, shown, unreadable_folders
from visualspeech.corpora.folder import existing_folder
from visualspeech.corpora.iemocap_texts import read_emotions, read_transcripts
from visualspeech.corpora.records import Utterance, displayable, legal_id
from visualspeech.errors import CorpusError

MOTION, SOUND, EMOTIONS, TRANSCRIPTS = "mocap_rotated", "wav", "emoevaluation", "transcriptions"
_RESTORE = "Restore the file from the corpus."
_DIALOG = re.compile(r"(Ses(\d\d)([FM]))_[A-Za-z0-9_]+", re.IGNORECASE)
_TURN = re.compile(r"(Ses(\d\d)([FM])_[A-Za-z0-9_]+)_([FM])[A-Z0-9]+", re.IGNORECASE)


def utterances(corpus: Mapping) -> list[Utterance]:
    """List the turns of the actors with markers, sorted by id; recordings are not opened, texts are read.

    Parameters
    ----------
    corpus : settings. ``root``: the folder of the release, or one that holds it. ``sessions`` (optional): numbers of
        the sessions to use; by default all. ``speaker`` (optional): an actor, such as ``Ses01F``. ``transcripts``:
        whether transcripts are read; without them nothing is aligned.

    Returns
    -------
    Utterances. The speaker is the actor: the session and the sex, ``Ses01F``. The emotion is that which most of the
    raters of a turn chose, or empty. A turn without sound or without motion capture has a ``problem``; one that its
    emotion file lacks has a ``warning``.

    Raises
    ------
    SettingError
        The root is not set or does not exist.
    CorpusError
        There are no turns, or none of the sessions or the speaker.
    """
    root = existing_folder(corpus.get("root"), corpus)
    found = find_files(root, {".txt", ".wav"})
    motion = _turns(found.files, MOTION, ".txt")
    sounds = _turns(found.files, SOUND, ".wav")
    if not motion:
        raise CorpusError(
            f"no motion capture of IEMOCAP in {shown(root)}. Set `root:` to the folder of the release, which holds "
            "Session1/sentences/MOCAP_rotated and so on; archives must be unpacked first."
        )
    turns = _selected(sorted(motion.keys() | sounds.keys()), corpus, root)
    emotions = _texts(found.files, EMOTIONS)
    transcripts = _texts(found.files, TRANSCRIPTS) if corpus.get("transcripts", True) else {}
    read: dict[tuple, tuple[dict[str, str], str]] = {}

    def looked_up(turn: str, files: Mapping[str, Path], reader, what: str) -> tuple[str, str]:
        """Text of a turn from its dialog's file, and what is wrong with it."""
        dialog = _TURN.fullmatch(turn)[1].lower()
        key = (reader, dialog)
        if key not in read:
            read[key] = _read(files.get(dialog), reader, f"{dialog_name(turn)}.txt", what)
        texts, wrong = read[key]
        if wrong or turn.lower() in texts:
            return texts.get(turn.lower(), ""), wrong
        return "", f"the {what} file {dialog_name(turn)}.txt does not hold the turn {turn}"

    listed = []
    for turn in turns:
        emotion, no_emotion = looked_up(turn, emotions, read_emotions, "emotion")
        transcript = looked_up(turn, transcripts, read_transcripts, "transcript")[0] if transcripts else ""
        fields = {"media": "", "speaker": speaker_of_turn(turn), "transcript": transcript, "emotion": emotion}
        if no_emotion:
            fields |= {"warning": no_emotion, "remedy": f"{_RESTORE} The turn is left out of the analysis of emotions."}
        listed.append(Utterance(id=legal_id(turn), **fields | _files_of(turn, motion, sounds)))
    return listed + list(unreadable_folders(found, root, _speaker_folder))


def speaker_of_turn(turn: str) -> str:
    """The actor of a turn, or of a dialog: session and sex, such as ``Ses01F``."""
    return f"Ses{turn[3:5]}{turn[5].upper()}"


def dialog_name(turn: str) -> str:
    """The dialog of a turn: ``Ses01F_impro01`` of ``Ses01F_impro01_F000``."""
    return _TURN.fullmatch(turn)[1]


def _turns(files, folder: str, ending: str) -> dict[str, Path]:
    """Turn of the actor with markers -> its file in ``<folder>/<dialog>/<turn><ending>``."""
    turns = {}
    for path in files:
        match = _TURN.fullmatch(path.stem)
        if match and path.suffix.lower() == ending and len(path.parts) > 2 and path.parts[-3].lower() == folder:
            if match[4].upper() == match[3].upper() and path.parts[-2].lower() == match[1].lower():
                turns.setdefault(path.stem, path)
    return turns


def _texts(files, folder: str) -> dict[str, Path]:
    """Dialog, in lower case -> its file in a folder of texts."""
    return {
        path.stem.lower(): path
        for path in reversed(files)
        if path.suffix.lower() == ".txt" and path.parent.name.lower() == folder and _DIALOG.fullmatch(path.stem)
    }


def _selected(turns: list[str], corpus: Mapping, root: Path) -> list[str]:
    """The turns of the wanted sessions and speaker."""
    sessions = {int(number) for number in corpus.get("sessions") or ()}
    there = sorted({int(turn[3:5]) for turn in turns})
    if sessions - set(there):
        raise CorpusError(
            f"no turns of session {', '.join(map(str, sorted(sessions - set(there))))} in {shown(root)}; there are "
            f"sessions {', '.join(map(str, there))}. Correct `sessions`."
        )
    turns = [turn for turn in turns if not sessions or int(turn[3:5]) in sessions]
    wanted = str(corpus.get("speaker") or "").lower()
    speakers = sorted({speaker_of_turn(turn) for turn in turns})
    if wanted and wanted not in map(str.lower, speakers):
        raise CorpusError(
            f"no turns of the speaker {corpus['speaker']!r} in {shown(root)}; there are {', '.join(speakers)}. Set "
            "`speaker` to one of them."
        )
    return [turn for turn in turns if not wanted or speaker_of_turn(turn).lower() == wanted]


def _read(path: Path | None, reader, name: str, what: str) -> tuple[dict[str, str], str]:
    """Turn in lower case -> text, from the file of a dialog; and what is wrong with the file."""
    if path is None:
        return {}, f"there is no {what} file {name}"
    try:
        return {turn.lower(): text for turn, text in reader(path).items()}, ""
    except OSError as error:
        return {}, f"the {what} file {displayable(path.name)} cannot be read: {error.strerror or error}"


def _files_of(turn: str, motion: Mapping[str, Path], sounds: Mapping[str, Path]) -> dict[str, str]:
    """Fields of the files of a turn; what is wrong with them."""
    dialog = dialog_name(turn)
    fields = recording_fields(motion[turn], "motion") if turn in motion else {
        "motion": f"MOCAP_rotated/{dialog}/{turn}.txt",
        "problem": f"no motion capture: there is no file sentences/MOCAP_rotated/{dialog}/{turn}.txt",
        "remedy": f"{_RESTORE} Some turns of the release have none.",
    }  # fmt: skip
    if turn in sounds:
        return {**recording_fields(sounds[turn], "audio"), **fields}
    missing = {"problem": f"no sound: there is no file sentences/wav/{dialog}/{turn}.wav", "remedy": _RESTORE}
    return {**missing, **fields}


def _speaker_folder(path: Path, root: Path) -> str:
    """Speaker of a file in the folder of a dialog; empty where that is none."""
    match = _DIALOG.fullmatch(path.parent.name)
    return speaker_of_turn(match[1]) if match else ""
