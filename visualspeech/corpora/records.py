"""The record of an utterance that every corpus adapter yields."""

import hashlib
import re
from dataclasses import dataclass


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

    @property
    def sound(self) -> str:
        """Path of the file that holds the sound."""
        return self.audio or self.media


def shard_of(utterance_id: str, shards: int) -> int:
    """Number of the shard of an utterance, by a stable hash of its id; adding an utterance changes one shard only."""
    return int(hashlib.sha256(utterance_id.encode()).hexdigest()[:8], 16) % shards


def legal_id(text: str) -> str:
    """An id made from a name; characters that ids may not contain become underscores."""
    return re.sub(r"^[-.]", "_", re.sub(r"[^A-Za-z0-9_.-]", "_", text)) or "_"
