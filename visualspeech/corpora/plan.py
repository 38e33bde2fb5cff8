"""The plan of a corpus, made before any job: which utterances there are, their shards and their split.

Tables are rewritten only where their content changes, so that planning again is no reason to run a job again.
"""

import fcntl
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from visualspeech.corpora.adapters import list_utterances
from visualspeech.corpora.records import Utterance, shard_of
from visualspeech.corpora.split import split_utterances
from visualspeech.errors import StorageError
from visualspeech.storage import write_text_if_changed

COLUMNS = ("id", "speaker", "media", "transcript", "emotion", "start", "end")


@dataclass(frozen=True)
class CorpusPlan:
    """Name and adapter of a corpus, its shards, the files that each shard reads, and the ids of its utterances."""

    name: str
    adapter: str
    shards: list[str]
    media: dict[str, list[str]]
    ids: frozenset[str]


def plan_corpus(corpus: Mapping, shards: int, shares: Mapping[str, float], seed: int, results: str) -> CorpusPlan:
    """List a corpus and write its tables under ``results/<name>/corpus``.

    Raises
    ------
    CorpusError, SettingError
        The corpus cannot be listed (see :func:`list_utterances`).
    StorageError
        The results folder cannot be written.
    """
    made_here = corpus["adapter"] == "demo"
    if made_here:
        corpus = {**corpus, "root": f"{results}/{corpus['name']}/recordings", "shards": shards}
    utterances = list_utterances(corpus)
    split = split_utterances(utterances, (shares["train"], shares["validation"], shares["test"]), seed)

    folder = Path(results, corpus["name"], "corpus")
    by_shard: dict[str, list[Utterance]] = {}
    for utterance in sorted(utterances, key=lambda one: one.id):
        by_shard.setdefault(str(shard_of(utterance.id, shards)), []).append(utterance)
    for shard, members in by_shard.items():
        rows = [[getattr(one, column) for column in COLUMNS] for one in members]
        write_text_if_changed(folder / "utterances" / f"{shard}.tsv", _tsv(COLUMNS, rows))
    write_text_if_changed(folder / "split.tsv", _tsv(("id", "split"), sorted(split.items())))

    if made_here:
        media = {shard: [f"{corpus['root']}/{shard}"] for shard in by_shard}
    else:
        # A listed file that is not there is a finding of the check, not a missing input.
        media = {shard: _existing(members) for shard, members in by_shard.items()}
    return CorpusPlan(corpus["name"], corpus["adapter"], sorted(by_shard, key=int), media, frozenset(split))


def _existing(utterances: list[Utterance]) -> list[str]:
    return sorted({one.media for one in utterances if os.path.exists(one.media)})


def _tsv(header, rows) -> str:
    """TSV without pandas, which would double the time to plan."""
    import csv
    import io

    text = io.StringIO()
    writer = csv.writer(text, delimiter="\t", lineterminator="\n")
    writer.writerows([header, *rows])
    return text.getvalue()


def hold(results: str):
    """Hold the results folder for this process; the operating system lets go when the process ends, however it ends.

    Returns the open lock file, to be kept for as long as the folder is held.

    Raises
    ------
    StorageError
        Another run holds the folder, or it cannot be written.
    """
    folder = Path(results)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = open(folder / ".lock", "w")  # noqa: SIM115 - held open on purpose
    except OSError as error:
        raise StorageError(
            f"cannot write to the results folder {folder.resolve()}: {error.strerror}. Give yourself the right to "
            "write there, or choose another working folder with --directory."
        ) from error
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        lock.close()
        raise StorageError(
            f"another run is using {folder.resolve()}. Wait for it to end, stop it, or choose another working folder "
            "with --directory."
        ) from None
    return lock
