"""Where the alignment of a corpus comes from, settled and checked before any job."""

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path

from visualspeech.corpora.aligning import AlignmentSources
from visualspeech.corpora.files import files_digest
from visualspeech.corpora.label_files import existing, find_label_files, probe
from visualspeech.corpora.records import Utterance
from visualspeech.errors import SettingError, plain_reason
from visualspeech.fields import with_defaults
from visualspeech.settings import read_yaml
from visualspeech.speech.alignment_settings import RECOGNISER, AlignmentSettings
from visualspeech.speech.dictionary import read_dictionary
from visualspeech.speech.given import Given, assembled
from visualspeech.speech.phone_sets import PRESETS, PhoneSet, checked_table
from visualspeech.storage.foreign import decoded, read_bytes

TABLES = (".tsv", ".csv", ".txt", ".yaml", ".yml")
PROBED = 10  # files that are tried before a run whose files cannot be used is refused
_HEAD = ("phone", "label", "ipa")  # of the first column of a table with a header line


@dataclass(frozen=True)
class AlignmentPlan:
    """How a corpus is aligned.

    Parameters
    ----------
    settings : all settings of the alignment, plain data of :class:`AlignmentSettings`
    sources : function of ids: the phone set, the dictionary and the files of these utterances, as plain data
    digest : function of ids: changes with these, and with the content or state of the files
    dictionary : path of a pronunciation dictionary and its phone set, plain data; empty where there is none
    dictionary_digest : function without arguments: changes with that, and with the content of the file
    check : raises :class:`SettingError` where the dictionary or the files cannot be used; reads some of them
    given : whether alignments are read from files
    arpabet : whether their phones are ARPAbet
    """

    settings: Mapping
    sources: Callable[[Sequence[str]], dict]
    digest: Callable[[Sequence[str]], list]
    dictionary: Mapping
    dictionary_digest: Callable[[], list]
    check: Callable[[], None]
    given: bool = False
    arpabet: bool = True


def corpus_alignment(run: Mapping, corpus: Mapping, where: str) -> dict:
    """Settings of the alignment of a corpus: its own over those of the run, defaults filled in.

    Raises
    ------
    SettingError
        They do not go together; ``where`` is the place of the corpus.
    """
    own = corpus.get("alignment") or {}
    return with_defaults(AlignmentSettings, {**run, **own}, where=f"{where}.alignment" if own else "alignment")


def plan_alignment(corpus: Mapping, utterances: Sequence[Utterance]) -> AlignmentPlan:
    """How a corpus is aligned. Its folder is listed; no file but a table of phones is read.

    Parameters
    ----------
    corpus : its settings, with ``alignment`` from :func:`corpus_alignment`

    Raises
    ------
    SettingError
        A folder, a file or a table does not exist, or the table is none.
    """
    plain = corpus.get("alignment") or with_defaults(AlignmentSettings, {})
    settings, root = AlignmentSettings(**plain), corpus.get("root") or ""
    phones = phone_set(settings.phones, root)
    dictionary = ""
    if settings.dictionary:
        dictionary = str(existing(settings.dictionary, root, "`alignment.dictionary`"))
    is_given = settings.source != RECOGNISER
    labels = find_label_files(corpus, settings, utterances) if is_given else None
    by_content = corpus.get("change_detection") == "content"

    own = {"path": dictionary, "phones": asdict(phones)} if dictionary else {}

    def sources(ids: Sequence[str]) -> dict:
        return AlignmentSources(phones, dictionary, labels and labels.part(ids)).plain()

    @cache
    def dictionary_digest() -> list:
        return [own, files_digest([dictionary], True) if dictionary else ""]

    @cache
    def state(ids: tuple[str, ...]) -> str:
        return files_digest(labels.paths(ids), by_content) if labels else ""

    def check() -> None:
        if dictionary:
            read_dictionary(dictionary, phones)
        if labels:
            probe(labels, settings, utterances, lambda given: _usable(given, phones), PROBED)

    return AlignmentPlan(
        settings=plain,
        sources=sources,
        digest=lambda ids: [sources(ids), state(tuple(ids)), dictionary_digest()],
        dictionary=own,
        dictionary_digest=dictionary_digest,
        check=check,
        given=is_given,
        arpabet=phones.is_arpabet,
    )


def _usable(given: Given, phones: PhoneSet) -> None:
    """Whether labels and times can be used; the length of the sound is not known yet."""
    last = max((one.end for one in given.phones), default=0.0)
    assembled(given, max(last, given.seconds), phones)


def phone_set(name: str, root: str = "") -> PhoneSet:
    """The phone set of a setting: a preset, or the table in a file.

    Raises
    ------
    SettingError
        There is no such preset or file, or it is no table.
    """
    if name in PRESETS:
        return PhoneSet(name)
    if not name.lower().endswith(TABLES):
        raise SettingError(
            f"`alignment.phones: {name[:80]}` is not known. Known: {', '.join(PRESETS)}. Or give the path of a table "
            f"({', '.join(TABLES)})."
        )
    path = existing(name, root, "`alignment.phones`")
    where = f"the table of phones {path}"
    table = read_yaml(path) if path.suffix.lower() in (".yaml", ".yml") else _table(path, where)
    return PhoneSet(os.path.basename(name), checked_table(table, where))


def _table(path: Path, where: str) -> dict[str, str]:
    try:
        lines = decoded(read_bytes(path)).splitlines()
    except OSError as error:
        raise SettingError(f"{where} cannot be read: {plain_reason(error)}.") from error
    separator = "," if path.suffix.lower() == ".csv" else "\t" if any("\t" in line for line in lines) else None
    found: dict[str, str] = {}
    for number, line in enumerate(lines, 1):
        if not line.strip():
            continue
        label, *rest = (part.strip().strip('"') for part in line.strip().split(separator, 1))
        if not rest or not rest[0]:
            raise SettingError(f"{where}, line {number}: {label[:40]!r} has no phones. Give its label, then ARPAbet.")
        if not found and label.lower() in _HEAD:
            continue
        if label in found:
            raise SettingError(f"{where}, line {number}: {label[:40]!r} is given twice; keep one.")
        found[label] = rest[0]
    return found
