"""Corpus adapters: from the settings of a corpus to its list of utterances."""

from collections.abc import Mapping
from hashlib import sha256

from visualspeech.corpora.records import Utterance, check_id
from visualspeech.corpora.split import SPLITS
from visualspeech.errors import CorpusError, SettingError


def _folder(corpus: Mapping) -> list[Utterance]:
    from visualspeech.corpora.folder import utterances

    return utterances(corpus)


def _grid(corpus: Mapping) -> list[Utterance]:
    from visualspeech.corpora.grid import utterances

    return utterances(corpus)


def _demo(corpus: Mapping) -> list[Utterance]:
    from visualspeech.corpora.demo.listing import utterances

    return utterances(corpus)


def _iemocap(corpus: Mapping) -> list[Utterance]:
    from visualspeech.corpora.iemocap import utterances

    return utterances(corpus)


def _mocap(corpus: Mapping) -> list[Utterance]:
    from visualspeech.corpora.mocap import utterances

    return utterances(corpus)


ADAPTERS = {"folder": _folder, "grid": _grid, "demo": _demo, "iemocap": _iemocap, "mocap": _mocap}
#: Those whose faces are recorded as motion capture, without video.
MOTION_ADAPTERS = ("iemocap", "mocap")


def list_utterances(corpus: Mapping) -> list[Utterance]:
    """List the utterances of a corpus, sorted by id; no recording is opened.

    Parameters
    ----------
    corpus : settings. ``name`` and ``adapter`` (a key of :data:`ADAPTERS`) are required. ``limit`` keeps that
        many utterances, chosen by a hash of their ids, for a trial run. Other settings are those of the adapter.

    Raises
    ------
    SettingError
        A setting is missing or has a wrong value.
    CorpusError
        The recordings cannot be found, an id or split is invalid, or two utterances have the same id.
    """
    name = corpus.get("adapter")
    if name not in ADAPTERS:
        raise SettingError(f"`adapter: {name}` of the corpus is unknown; give one of {', '.join(sorted(ADAPTERS))}.")
    limit = corpus.get("limit") or 0
    if isinstance(limit, bool) or not isinstance(limit, int) or limit < 0:
        raise SettingError(
            f"`limit: {limit}` of the corpus is not a number of utterances; give 1 or more, or leave it out."
        )
    utterances = ADAPTERS[name](corpus)
    _check(utterances)
    if limit:
        utterances = sorted(utterances, key=lambda one: sha256(one.id.encode()).digest())[:limit]
    return sorted(utterances, key=lambda one: one.id)


def _check(utterances: list[Utterance]) -> None:
    seen: dict[str, Utterance] = {}
    # Some file systems do not distinguish names that differ only in case.
    for one in utterances:
        check_id(one.id, one.file)
        if one.id.lower() in seen:
            other = seen[one.id.lower()]
            raise CorpusError(
                f"two utterances have one id, {other.id!r} and {one.id!r} (ids are compared without regard to case): "
                f"{_location(other)} and {_location(one)}. Rename one of the files, or give each its own id in the "
                "corpus's table."
            )
        seen[one.id.lower()] = one
        if one.split and one.split not in SPLITS:
            raise CorpusError(
                f"{one.file}: the split of utterance {one.id} is {one.split!r}; give one of {', '.join(SPLITS)}, or "
                "leave the column out to have the workflow split the corpus."
            )


def _location(one: Utterance) -> str:
    return f"{one.file} ({one.start:g}-{one.end:g} s)" if one.end or one.start else one.file
