"""The adapter ``demo``: the utterances of the demo corpora, listed without rendering."""

import random
from collections.abc import Mapping, Sequence
from pathlib import Path

from visualspeech.corpora.demo.characters import CHARACTERS, EMOTIONS
from visualspeech.corpora.demo.sentences import SENTENCES, SHORT_SENTENCES
from visualspeech.corpora.records import Utterance, shard_of
from visualspeech.errors import SettingError

SPEAKER = "demo"
#: Split of the first rounds of a corpus with emotions; a round is one utterance of each speaker with each emotion.
ROUNDS = ("train", "test", "validation", "train", "train", "train", "test", "validation")


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
        ``seed`` (of the choice of sentences, default 1), ``shards`` (number of shards; each recording is then in the
        subfolder of its shard), ``speakers`` and ``emotions`` (names, of
        :mod:`visualspeech.corpora.demo.characters`). With emotions the sentences are short, each speaker says every
        sentence once, and the split has every emotion of every speaker in each part, if there are enough utterances.

    Raises
    ------
    SettingError
        ``root`` is missing, a number is out of range, or a speaker or emotion is unknown.
    """
    if not corpus.get("root"):
        raise SettingError("the demo corpus needs the key `root`: the folder that its recordings are written to.")
    speakers = _known(corpus, "speakers", CHARACTERS) or [SPEAKER]
    emotions = _known(corpus, "emotions", EMOTIONS)
    sentences = SHORT_SENTENCES if emotions else SENTENCES
    count, most = corpus.get("utterances", 60), len(sentences) * len(speakers)
    if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= most:
        raise SettingError(f"`utterances` of the demo corpus is {count!r}; give a whole number, 1 to {most}.")
    shards = corpus.get("shards")
    if shards is not None and (isinstance(shards, bool) or not isinstance(shards, int) or shards < 1):
        raise SettingError(f"`shards` of the demo corpus is {shards!r}; give a whole number, 1 or more.")
    # The first sentences of a fixed order, so that a larger corpus contains a smaller one.
    order = list(range(len(sentences)))
    random.Random(int(corpus.get("seed", 1))).shuffle(order)
    if speakers == [SPEAKER] and not emotions:
        return [_utterance(number, corpus["root"], shards) for number in sorted(order[:count])]
    found = [
        _of_character(index, order, sentences, speakers, emotions, corpus["root"], shards, count)
        for index in range(count)
    ]
    return sorted(found, key=lambda one: one.id)


def _known(corpus: Mapping, key: str, known: Mapping) -> list[str]:
    """The names of a setting, without repetition, in their order."""
    names = corpus.get(key) or []
    unknown = [name for name in names if name not in known] if isinstance(names, Sequence) else [names]
    if unknown or isinstance(names, str):
        raise SettingError(f"`{key}` of the demo corpus is {names!r}; give a list of {', '.join(known)}.")
    return list(dict.fromkeys(names))


def _utterance(number: int, root: str | Path, shards: int | None) -> Utterance:
    name = f"demo{number + 1:03d}"
    shard = None if shards is None else shard_of(name, shards)
    return Utterance(name, SPEAKER, str(media_path(root, name, shard)), SENTENCES[number])


def _of_character(
    index: int,
    order: Sequence[int],
    sentences: Sequence[str],
    speakers: Sequence[str],
    emotions: Sequence[str],
    root: str | Path,
    shards: int | None,
    count: int,
) -> Utterance:
    """Utterance ``index`` of ``count``: the speakers take turns, and each goes through sentences and emotions.

    Speakers begin with different emotions, so that no sentence tells its emotion.
    """
    speaker, turn = index % len(speakers), index // len(speakers)
    emotion = emotions[(turn + speaker) % len(emotions)] if emotions else ""
    name = "_".join(filter(None, [f"{speakers[speaker]}{order[turn] + 1:02d}", emotion]))
    shard = None if shards is None else shard_of(name, shards)
    split = ""
    per_round = len(speakers) * len(emotions)
    if emotions and count >= 3 * per_round:
        split = ROUNDS[index // per_round % len(ROUNDS)]
    media = str(media_path(root, name, shard))
    return Utterance(name, speakers[speaker], media, sentences[order[turn]], split=split, emotion=emotion)
