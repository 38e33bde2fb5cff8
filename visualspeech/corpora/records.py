"""The record of an utterance that every corpus adapter yields."""

import hashlib
import re
import unicodedata
from dataclasses import dataclass

from visualspeech.errors import CorpusError

LEGAL_ID = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]*")
#: Longest id, in characters. Files are named by ids, and with the longest prefix and suffix that this project adds
#: (``.partial.<process>.<id>.TextGrid``) a name must fit in the 255 bytes of a file system.
MAX_ID = 200
_HASH = 10  # hexadecimal digits: a thousand names have two with one hash once in two million corpora


@dataclass(frozen=True)
class Utterance:
    """One utterance of one speaker.

    Parameters
    ----------
    id : unique in the corpus; letters, digits, ``-``, ``_`` and ``.``
    speaker : name of the speaker
    media : path of the video recording, with or without sound; empty if there is none
    transcript : what is said, as written; empty if the corpus has none
    split : ``train``, ``validation`` or ``test``; empty if the corpus has no split
    emotion : label of the corpus, or empty
    start, end : segment of the recording, in seconds; an ``end`` of 0 means to the recording's end
    audio : path of a separate sound file; empty if the sound is that of ``media``
    motion : path of the motion capture; empty if there is none
    problem : why the adapter found that the utterance cannot be used; the check rejects it with this reason
    remedy : what the user can do about the problem, or about the warning
    warning : what the adapter found that does not prevent its use; the check reports it
    """

    id: str
    speaker: str
    media: str
    transcript: str
    split: str = ""
    emotion: str = ""
    start: float = 0.0
    end: float = 0.0
    audio: str = ""
    motion: str = ""
    problem: str = ""
    remedy: str = ""
    warning: str = ""

    @property
    def file(self) -> str:
        """Path of the recorded face, as messages name it: the video, or else the motion capture."""
        return self.media or self.motion or self.audio

    @property
    def sound(self) -> str:
        """Path of the file that holds the sound."""
        return self.audio or self.media


def shard_of(utterance_id: str, shards: int) -> int:
    """Number of the shard of an utterance, by a stable hash of its id; adding an utterance changes one shard only."""
    return int(hashlib.sha256(utterance_id.encode()).hexdigest()[:8], 16) % shards


def legal_id(text: str) -> str:
    """An id made from a name; a name that is a legal id of at most :data:`MAX_ID` characters stays as it is.

    Characters that ids may not contain become underscores, and too long names are cut off. A hash of the name then
    follows, so that names which differ have ids that differ. Composed and decomposed spellings of a name have one id.
    """
    text = unicodedata.normalize("NFC", text)
    legal = re.sub(r"^[-.]", "_", re.sub(r"[^A-Za-z0-9_.-]", "_", text)) or "_"
    if legal == text and len(legal) <= MAX_ID:
        return legal
    # File names that are not UTF-8 hold surrogates in place of their bytes.
    code = hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()[:_HASH]
    return f"{legal[: MAX_ID - _HASH - 1]}-{code}"


def check_id(name: str, where: str) -> None:
    """Check an id that a corpus gives; ``where`` says where it stands, for the message.

    Raises
    ------
    CorpusError
        It holds other characters than ids may have, or is too long.
    """
    if not LEGAL_ID.fullmatch(name):
        raise CorpusError(
            f"{where}: the id {name!r} cannot be used. Use letters A-Z, digits, '-', '_' and '.'; begin with a letter, "
            "a digit or '_'."
        )
    if len(name) > MAX_ID:
        raise CorpusError(
            f"{where}: the id {name[:20]}... has {len(name)} characters; give one of at most {MAX_ID}, since files are "
            "named by it."
        )


def displayable(text: str) -> str:
    """A path or name as a table can hold it: as UTF-8 text, bytes that are not UTF-8 and carriage returns escaped."""
    return text.encode("utf-8", "surrogateescape").decode("utf-8", "backslashreplace").replace("\r", "\\r")
