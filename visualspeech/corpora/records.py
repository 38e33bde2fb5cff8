"""The one record that every corpus adapter yields."""

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
    media : path of the recording (video with sound)
    transcript : what is said, as written
    split : ``train``, ``validation``, ``test``, or empty where the corpus brings none
    emotion : label of the corpus, or empty
    start, end : the part of the recording that is this utterance, in seconds; an ``end`` of 0 means to its end
    """

    id: str
    speaker: str
    media: str
    transcript: str
    split: str = ""
    emotion: str = ""
    start: float = 0.0
    end: float = 0.0


def shard_of(utterance_id: str, shards: int) -> int:
    """Shard of an utterance by a stable hash of its id: adding one utterance touches one shard."""
    return int(hashlib.sha256(utterance_id.encode()).hexdigest()[:8], 16) % shards


def legal_id(text: str) -> str:
    """An id made of a file name: characters that an id may not have become underscores."""
    return re.sub(r"^[-.]", "_", re.sub(r"[^A-Za-z0-9_.-]", "_", text)) or "_"
