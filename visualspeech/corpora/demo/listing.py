"""The adapter ``demo``: the utterances of the demo corpus, listed without rendering."""

import random
from collections.abc import Mapping
from pathlib import Path

from visualspeech.corpora.demo.sentences import SENTENCES
from visualspeech.corpora.records import Utterance, shard_of
from visualspeech.errors import SettingError

SPEAKER = "demo"


def media_path(root: str | Path, utterance_id: str, shard: int | None = None) -> Path:
    """Path of the recording of an utterance, existing or not: ``root/id.mp4``, or ``root/shard/id.mp4``."""
    folder = Path(root) if shard is None else Path(root) / str(shard)
    return folder / f"{utterance_id}.mp4"


def utterances(corpus: Mapping) -> list[Utterance]:
    """List the utterances of the demo corpus, sorted by id.

    Parameters
    ----------
    corpus : settings: ``root`` (folder of the recordings, which
        :func:`visualspeech.corpora.demo.recording.record_shard` makes), ``utterances`` (their number, default 60),
        ``seed`` (of the choice of sentences, default 1) and ``shards`` (number of shards; each recording is then in the
        subfolder of its shard).

    Raises
    ------
    SettingError
        ``root`` is missing, or a number is out of range.
    """
    if not corpus.get("root"):
        raise SettingError("the demo corpus needs the key `root`: the folder that its recordings are written to.")
    count = corpus.get("utterances", 60)
    if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= len(SENTENCES):
        raise SettingError(f"`utterances` of the demo corpus is {count!r}; give a whole number, 1 to {len(SENTENCES)}.")
    shards = corpus.get("shards")
    if shards is not None and (isinstance(shards, bool) or not isinstance(shards, int) or shards < 1):
        raise SettingError(f"`shards` of the demo corpus is {shards!r}; give a whole number, 1 or more.")
    # The first sentences of a fixed order, so that a larger corpus contains a smaller one.
    order = list(range(len(SENTENCES)))
    random.Random(int(corpus.get("seed", 1))).shuffle(order)
    return [_utterance(number, corpus["root"], shards) for number in sorted(order[:count])]


def _utterance(number: int, root: str | Path, shards: int | None) -> Utterance:
    name = f"demo{number + 1:03d}"
    shard = None if shards is None else shard_of(name, shards)
    return Utterance(name, SPEAKER, str(media_path(root, name, shard)), SENTENCES[number])
