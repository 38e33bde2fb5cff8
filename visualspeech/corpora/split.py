"""Split of a corpus into training, validation (early stopping) and test utterances."""

import hashlib
from collections.abc import Iterable, Sequence

from visualspeech.corpora.records import Utterance
from visualspeech.errors import CorpusError, SettingError

SPLITS = ("train", "validation", "test")


def split_utterances(
    utterances: Iterable[Utterance], fractions: Sequence[float] = (0.8, 0.1, 0.1), seed: int = 0
) -> dict[str, str]:
    """Split of a corpus by utterance: id -> ``train``, ``validation`` or ``test``, in the order of the ids.

    A corpus with its own split keeps it. Otherwise the utterances of each speaker are ordered by a hash of the seed and
    the id and divided at the fractions, with at least one utterance per split. The split is thus stratified by speaker,
    does not depend on the order of the corpus, and changes little when the corpus grows. Utterances with a ``problem``,
    which the check rejects, count as training utterances and have no part in it.

    Raises
    ------
    SettingError
        The fractions are negative, or their sum is not 1.
    CorpusError
        A speaker has fewer than three utterances, or the corpus's own split is incomplete.
    """
    every = sorted(utterances, key=lambda one: one.id)
    utterances = [one for one in every if not one.problem]
    split_of = {one.id: SPLITS[0] for one in every}
    if any(one.split for one in utterances):
        return split_of | _given_split(utterances)
    if len(fractions) != 3 or min(fractions) <= 0 or abs(sum(fractions) - 1) > 1e-6:
        shown = ", ".join(f"{name} {share:g}" for name, share in zip(SPLITS, fractions, strict=False))
        raise SettingError(f"the shares of `split` are {shown}; give three numbers above 0 whose sum is 1.")
    speakers: dict[str, list[Utterance]] = {}
    for one in utterances:
        speakers.setdefault(one.speaker, []).append(one)
    for of_speaker in list(speakers.values()) or [[]]:
        split_of |= _split_speaker(of_speaker, fractions, seed)
    return split_of


def _split_speaker(utterances: Sequence[Utterance], fractions: Sequence[float], seed: int) -> dict[str, str]:
    """The split of one speaker's utterances."""
    if len(utterances) < 3:
        whose = f"the speaker {utterances[0].speaker!r} has" if utterances else "the corpus has"
        raise CorpusError(
            f"{whose} {len(utterances)} utterances. Give at least three, one each for training, validation and test; "
            "useful models need some hundreds."
        )
    count = len(utterances)
    others = [max(1, round(count * share)) for share in fractions[1:]]
    while sum(others) > count - 1:  # with few utterances, rounding may leave none for training
        others[others.index(max(others))] -= 1
    borders = (count - sum(others), count - others[1], count)
    ordered = sorted(utterances, key=lambda one: hashlib.sha256(f"{seed}:{one.id}".encode()).digest())
    return {one.id: SPLITS[sum(index >= border for border in borders)] for index, one in enumerate(ordered)}


def _given_split(utterances: list[Utterance]) -> dict[str, str]:
    """The split that the corpus itself gives."""
    without = [one for one in utterances if not one.split]
    if without:
        raise CorpusError(
            f"{without[0].file}: utterance {without[0].id} has no split, while others have one "
            f"({len(without)} of {len(utterances)} are without). Give all utterances a split, or none."
        )
    for name in SPLITS:
        if not any(one.split == name for one in utterances):
            raise CorpusError(
                f"the corpus's own split has no utterance in {name!r}. Mark some utterances {name}, or leave the split "
                "out to have the workflow split the corpus."
            )
    return {one.id: one.split for one in utterances}
