"""The plan of a corpus, made before any job: its utterances, their shards, split and speakers. Writes nothing."""

import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass

from visualspeech.corpora.adapters import list_utterances
from visualspeech.corpora.records import Utterance, legal_id, shard_of
from visualspeech.corpora.split import split_utterances
from visualspeech.errors import CorpusError


@dataclass(frozen=True)
class CorpusPlan:
    """A corpus as the rules see it.

    Parameters
    ----------
    name, adapter, consent : from its settings
    shards : numbers of the shards that hold utterances, as text, ascending
    utterances : shard -> its utterances
    split : id -> train, validation or test
    media : shard -> files that its jobs read
    speakers : file name of a speaker -> the speaker, sorted
    gives : what the corpus gives, of :data:`visualspeech.planning.systems.NEEDS`
    """

    name: str
    adapter: str
    consent: str
    shards: list[str]
    utterances: Mapping[str, list[Utterance]]
    split: Mapping[str, str]
    media: Mapping[str, list[str]]
    speakers: Mapping[str, str]
    gives: frozenset[str]

    def rows(self, shard: str) -> list[dict]:
        """The utterances of a shard as plain data."""
        return [asdict(one) for one in self.utterances[shard]]

    def test_utterances(self) -> int:
        """Number of utterances in the test split, before any is rejected."""
        return sum(split == "test" for split in self.split.values())


def plan_corpus(corpus: Mapping, shards: int, shares: Mapping[str, float], seed: int, results: str) -> CorpusPlan:
    """List a corpus.

    Parameters
    ----------
    corpus : its settings
    shards : number of shards that utterances are assigned to
    shares : of train, validation and test
    seed : of the split
    results : folder of the results, in which the demo corpus is recorded

    Raises
    ------
    CorpusError, SettingError
        The corpus cannot be listed (see :func:`list_utterances`).
    """
    made_here = corpus["adapter"] == "demo"
    if made_here:
        corpus = {**corpus, "root": f"{results}/{corpus['name']}/recordings", "shards": shards}
    utterances = list_utterances(corpus)
    split = split_utterances(utterances, (shares["train"], shares["validation"], shares["test"]), seed)
    by_shard: dict[str, list[Utterance]] = {}
    for utterance in sorted(utterances, key=lambda one: one.id):
        by_shard.setdefault(str(shard_of(utterance.id, shards)), []).append(utterance)
    if made_here:
        media = {shard: [f"{corpus['root']}/{shard}"] for shard in by_shard}
    else:
        # A listed file that is missing is a finding of the check, not a missing input.
        media = {shard: _existing(members) for shard, members in by_shard.items()}
    return CorpusPlan(
        name=corpus["name"],
        adapter=corpus["adapter"],
        consent=corpus.get("consent", ""),
        shards=sorted(by_shard, key=int),
        utterances=by_shard,
        split=split,
        media=media,
        speakers=_speakers(utterances, corpus["name"]),
        gives=_gives(utterances),
    )


def _existing(utterances: list[Utterance]) -> list[str]:
    files = {path for one in utterances for path in (one.media, one.audio, one.motion) if path}
    return sorted(path for path in files if os.path.exists(path))


def _speakers(utterances: list[Utterance], corpus: str) -> dict[str, str]:
    """File name of each speaker -> speaker.

    Raises
    ------
    CorpusError
        Two speakers would share a file name.
    """
    found: dict[str, str] = {}
    for speaker in sorted({one.speaker for one in utterances}):
        name = legal_id(speaker)
        if name in found:
            raise CorpusError(
                f"the speakers {found[name]!r} and {speaker!r} of the corpus {corpus} differ only in characters that a "
                "file name cannot have; rename one of them."
            )
        found[name] = speaker
    return found


def _gives(utterances: list[Utterance]) -> frozenset[str]:
    video, motion = all(one.media for one in utterances), all(one.motion for one in utterances)
    given = {
        "video": video,
        "audio": all(one.sound for one in utterances),
        "text": any(one.transcript for one in utterances),
        "motion": motion,
        "faces": video or motion,
        "one_speaker": len({one.speaker for one in utterances}) == 1,
        "emotion": any(one.emotion for one in utterances),
    }
    return frozenset(name for name, there in given.items() if there)
