"""The plan of a corpus, made before any job: its utterances, their shards, split and speakers. Writes nothing."""

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from functools import cache

from visualspeech.corpora.adapters import MOTION_ADAPTERS, list_utterances
from visualspeech.corpora.files import recordings_digest
from visualspeech.corpora.records import Utterance, legal_id, shard_of
from visualspeech.corpora.split import split_utterances
from visualspeech.errors import CorpusError
from visualspeech.face.markers import MarkerSet
from visualspeech.planning.alignment import AlignmentPlan, plan_alignment
from visualspeech.planning.motion import corpus_markers, motion_source


@dataclass(frozen=True)
class CorpusPlan:
    """A corpus as the rules see it.

    Parameters
    ----------
    name, adapter, consent : from its settings
    shards : numbers of the shards that hold utterances, as text, ascending
    utterances : shard -> its utterances
    split : id -> train, validation or test
    recorded_here : shard -> folder that the workflow records it in; empty for a corpus of the user
    recordings : function of a shard: digest of its files, which changes with them; they are looked at when it is called
    speakers : file name of a speaker -> the speaker, sorted
    gives : what the corpus gives, of :data:`visualspeech.planning.systems.NEEDS`
    markers : of its motion capture, by region; None where its faces are landmarks of videos
    motion : how its motion capture is read, plain data of :class:`visualspeech.corpora.motion.MotionSource`; empty if
        there is none
    alignment : where its alignment comes from
    """

    name: str
    adapter: str
    consent: str
    shards: list[str]
    utterances: Mapping[str, list[Utterance]]
    split: Mapping[str, str]
    recorded_here: Mapping[str, str]
    recordings: Callable[[str], str]
    speakers: Mapping[str, str]
    gives: frozenset[str]
    alignment: AlignmentPlan
    markers: MarkerSet | None = None
    motion: Mapping = field(default_factory=dict)

    def rows(self, shard: str) -> list[dict]:
        """The utterances of a shard as plain data."""
        return [asdict(one) for one in self.utterances[shard]]

    def ids(self, shard: str) -> list[str]:
        """Ids of the utterances of a shard whose files can be looked at."""
        return [one.id for one in self.utterances[shard] if not one.problem]

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
    # First what may be a mistake of the settings: a large corpus takes a while to list.
    markers = corpus_markers(corpus) if corpus["adapter"] in MOTION_ADAPTERS else None
    utterances = list_utterances(corpus)
    usable = [one for one in utterances if not one.problem]
    if not usable:
        first = utterances[0]
        raise CorpusError(
            f"no utterance of the corpus {corpus['name']} can be used ({len(utterances)} are listed). The first one, "
            f"{first.file}: {first.problem}. {first.remedy}"
        )
    alignment = plan_alignment(corpus, usable)
    split = split_utterances(utterances, (shares["train"], shares["validation"], shares["test"]), seed)
    by_shard: dict[str, list[Utterance]] = {}
    for utterance in sorted(utterances, key=lambda one: one.id):
        by_shard.setdefault(str(shard_of(utterance.id, shards)), []).append(utterance)
    by_content = corpus.get("change_detection") == "content"
    return CorpusPlan(
        name=corpus["name"],
        adapter=corpus["adapter"],
        consent=corpus.get("consent", ""),
        shards=sorted(by_shard, key=int),
        utterances=by_shard,
        split=split,
        recorded_here={shard: f"{corpus['root']}/{shard}" for shard in by_shard} if made_here else {},
        # Files that the run itself makes are inputs of its jobs; their digest at planning would say nothing.
        recordings=cache(lambda shard: "" if made_here else recordings_digest(by_shard[shard], by_content)),
        speakers=_speakers(usable, corpus["name"]),
        gives=_gives(usable, alignment),
        alignment=alignment,
        markers=markers,
        motion=motion_source(corpus, markers) if markers else {},
    )


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
                f"the speakers {found[name]!r} and {speaker!r} of the corpus {corpus} differ only in how their letters "
                "are encoded; rename one of them."
            )
        found[name] = speaker
    return found


def _gives(utterances: list[Utterance], alignment: AlignmentPlan) -> frozenset[str]:
    video, motion = all(one.media for one in utterances), all(one.motion for one in utterances)
    given = {
        "video": video,
        "audio": all(one.sound for one in utterances),
        "text": alignment.given or any(one.transcript for one in utterances),
        "arpabet": alignment.arpabet,
        "motion": motion,
        "faces": video or motion,
        "one_speaker": len({one.speaker for one in utterances}) == 1,
        "emotion": any(one.emotion for one in utterances),
    }
    return frozenset(name for name, there in given.items() if there)
