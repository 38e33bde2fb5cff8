"""The files that hold the alignment of each utterance of a corpus: found when a run is planned, read by its jobs."""

import os
import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from visualspeech.corpora.ctm import CtmFiles
from visualspeech.corpora.files import find_files, shown, suffix
from visualspeech.corpora.records import Utterance, displayable, legal_id
from visualspeech.corpora.textgrids import read_textgrid
from visualspeech.errors import RejectedUtterance, SettingError
from visualspeech.speech.alignment_settings import CTM, AlignmentSettings
from visualspeech.speech.given import Given, cut

SUFFIXES = {"textgrid": ".textgrid", "ctm": ".ctm"}


@dataclass(frozen=True)
class LabelFile:
    """Where the alignment of an utterance is.

    Parameters
    ----------
    names : of TextGrids one path, or none if there is no file; of CTM files the names that the utterance may have
    begin, end : part of the file that the utterance is, in seconds for each name; an end of 0 is the file's end
    problem : why there is none
    """

    names: tuple[str, ...] = ()
    begin: tuple[float, ...] = ()
    end: tuple[float, ...] = ()
    problem: str = ""


@dataclass(frozen=True)
class LabelFiles:
    """The alignment files of a corpus.

    Parameters
    ----------
    folder : in which they lie, for messages
    utterances : id -> where its alignment is
    words, phones : paths of CTM files
    """

    folder: str
    utterances: Mapping[str, LabelFile]
    words: tuple[str, ...] = ()
    phones: tuple[str, ...] = ()

    def paths(self, ids: Iterable[str]) -> list[str]:
        """Paths of all files that the alignments of some utterances are read from."""
        return [*self.words, *self.phones] or [path for name in ids for path in self.utterances[name].names]

    def part(self, ids: Iterable[str]) -> "LabelFiles":
        """The files of some utterances."""
        return LabelFiles(self.folder, {name: self.utterances[name] for name in ids}, self.words, self.phones)

    def plain(self) -> dict:
        """Plain data, of which :meth:`of` makes it again."""
        found = {name: [list(one.names), list(one.begin), list(one.end), one.problem]
                 for name, one in self.utterances.items()}  # fmt: skip
        return {"folder": self.folder, "utterances": found, "words": list(self.words), "phones": list(self.phones)}

    @classmethod
    def of(cls, plain: Mapping) -> "LabelFiles":
        """The inverse of :meth:`plain`."""
        found = {
            name: LabelFile(*(tuple(one) for one in fields[:3]), fields[3])
            for name, fields in plain["utterances"].items()
        }
        return cls(plain["folder"], found, tuple(plain["words"]), tuple(plain["phones"]))


class LabelReader:
    """Reads the intervals of utterances; CTM files are read once, for the utterances of the files alone."""

    def __init__(self, files: LabelFiles, settings: AlignmentSettings) -> None:
        self._files, self._settings, self._ctm = files, settings, None
        self._last: tuple[tuple[str, str], Given] | None = None  # parts of one recording share a TextGrid
        if settings.source == CTM:
            wanted = {name for one in files.utterances.values() for name in one.names}
            self._ctm = CtmFiles(files.words, files.phones, wanted, settings.word_tier, settings.phone_tier)

    def read(self, utterance: Utterance) -> Given:
        """The intervals of an utterance, with times from its beginning.

        Raises
        ------
        RejectedUtterance
            There is no file, or it cannot be read (:func:`read_textgrid`, :meth:`CtmFiles.given`).
        """
        own = self._files.utterances[utterance.id]
        if own.problem:
            raise RejectedUtterance(
                own.problem, f"Align the recording and put its file into {self._files.folder}, or leave it out."
            )
        if self._ctm is None:
            given, number = self._textgrid(own.names[0], utterance.speaker), 0
        else:
            number = next((k for k, name in enumerate(own.names) if self._ctm.has(name)), 0)
            given = self._ctm.given(own.names[number])
        begin, end = own.begin[number], own.end[number]
        return cut(given, begin, end) if begin or end else given

    def _textgrid(self, path: str, speaker: str) -> Given:
        if self._last is None or self._last[0] != (path, speaker):
            found = read_textgrid(path, self._settings.word_tier, self._settings.phone_tier, speaker)
            self._last = ((path, speaker), found)
        return self._last[1]


def find_label_files(corpus: Mapping, settings: AlignmentSettings, utterances: Sequence[Utterance]) -> LabelFiles:
    """The files in which the alignment of each utterance lies; an utterance without one gets a ``problem``.

    A TextGrid is named as the recording, in the same folder below ``folder`` as the recording below the corpus's root,
    or anywhere where the name is not ambiguous; or it is named by the id of the utterance. A file that is named as the
    recording is that of the whole recording, also where an utterance is only a part of it.

    Raises
    ------
    SettingError
        There is no such folder or file, or it holds no such files.
    """
    where = f"`alignment.folder` of the corpus {corpus['name']}"
    root = corpus.get("root") or ""
    folder = existing(settings.folder or root, root if settings.folder else "", where)
    if settings.source == CTM:
        words, phones = _ctm_files(folder, settings, where)
        return LabelFiles(shown(folder), {one.id: _names(one, root) for one in utterances}, words, phones)
    if not folder.is_dir():
        raise SettingError(f"{where} is a file: {shown(folder)}. Give the folder of the TextGrid files.")
    index = _Index(folder, find_files(folder, (SUFFIXES["textgrid"],)).files)
    if not index.by_id:
        raise SettingError(
            f"{where}: there is no TextGrid file in {shown(folder)} or the folders inside. Give the folder that your "
            "aligner wrote them to."
        )
    found = {one.id: index.file_of(one, root) for one in utterances}
    if all(one.problem for one in found.values()):
        first = utterances[0]
        raise SettingError(
            f"{where}: none of the {len(index.by_id)} TextGrid files in {shown(folder)} is named as a recording of the "
            f"corpus; {found[first.id].problem}. Name each as its recording."
        )
    return LabelFiles(shown(folder), found)


def existing(path: str, root: str, where: str) -> Path:
    """A path of the settings: from the root of the corpus, or else from the working folder.

    Raises
    ------
    SettingError
        It is empty, or there is nothing of that name; ``where`` names the setting.
    """
    if not path:
        raise SettingError(f"{where} is empty and the corpus has no `root`. Give the folder of the files.")
    given = os.path.expanduser(path)
    for one in (Path(os.path.expanduser(root), given), Path(given)):
        if os.path.exists(one):
            return one
    raise SettingError(
        f"{where}: {displayable(path)[:200]} does not exist, neither in the root of the corpus nor in the working "
        f"folder {displayable(os.getcwd())}."
    )


def _key(text: str) -> str:
    return unicodedata.normalize("NFC", text)


def _of_media(one: Utterance, root: str) -> tuple[str, str]:
    """Id of the path of a recording below the root, and the stem of its name."""
    path = Path(os.path.splitext(one.file)[0])
    base = Path(os.path.expanduser(root))
    inside = path.relative_to(base) if root and path.is_relative_to(base) else Path(path.name)
    return legal_id("-".join(inside.parts)), _key(path.name)


class _Index:
    """TextGrid files by the id that their path gives, and by their stem."""

    def __init__(self, folder: Path, files: Sequence[Path]) -> None:
        self.folder = folder
        self.by_id: dict[str, Path] = {}
        self.by_stem: dict[str, list[Path]] = {}
        for path in files:
            parts = path.relative_to(folder).with_suffix("").parts
            self.by_id.setdefault(legal_id("-".join(parts)), path)
            self.by_stem.setdefault(_key(parts[-1]), []).append(path)

    def file_of(self, one: Utterance, root: str) -> LabelFile:
        of_path, stem = _of_media(one, root)
        if one.id not in (of_path, stem) and (found := self._found(one.id, one.id, one)):
            return found if found.problem else LabelFile(found.names, (0.0,), (0.0,))
        found = self._found(of_path, stem, one)
        if found is None:
            return LabelFile(problem=f"there is no {displayable(stem)}.TextGrid")
        return found if found.problem else LabelFile(found.names, (one.start,), (one.end,))

    def _found(self, name: str, stem: str, one: Utterance) -> LabelFile | None:
        if name in self.by_id:
            return LabelFile((str(self.by_id[name]),))
        paths = self.by_stem.get(stem, [])
        near = [path for path in paths if path.parent.name in (one.speaker, Path(one.file).parent.name)]
        if len(paths) > 1 and len(near) != 1:
            names = " and ".join(displayable(str(path.relative_to(self.folder))) for path in paths[:2])
            return LabelFile(problem=f"several files are named as the recording: {names}")
        return LabelFile((str((near or paths)[0]),)) if paths else None


def _names(one: Utterance, root: str) -> LabelFile:
    """The names that an utterance may have in CTM files: its id, that of its path, its stem."""
    names = [one.id, *_of_media(one, root)]
    whole = [name in names[1:] for name in names]
    kept = list(dict.fromkeys(zip(names, whole, strict=True)))
    return LabelFile(
        tuple(name for name, _ in kept),
        tuple(one.start if own else 0.0 for _, own in kept),
        tuple(one.end if own else 0.0 for _, own in kept),
    )


def _ctm_files(folder: Path, settings: AlignmentSettings, where: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Paths of the CTM files of words and of phones."""
    tiers = (settings.word_tier.lower(), settings.phone_tier.lower())
    if folder.is_dir():
        files = find_files(folder, (SUFFIXES["ctm"],)).files
    else:
        files = [folder, *(one for one in sorted(folder.parent.iterdir()) if suffix(one.name) == SUFFIXES["ctm"])]
    found = tuple(
        tuple(dict.fromkeys(str(one) for one in files if _is_of(one.name.lower(), tier, other) and os.path.isfile(one)))
        for tier, other in (tiers, tiers[::-1])
    )
    if not folder.is_dir():
        found = (found[0], (str(folder),))
    for tier, paths in zip((settings.word_tier, settings.phone_tier), found, strict=True):
        if not paths:
            raise SettingError(
                f"{where}: there is no CTM file of {tier} in {shown(folder if folder.is_dir() else folder.parent)}; "
                f"its name must contain {_singular(tier)!r} and end in .ctm. Rename it, or set `alignment.word_tier` "
                "and `alignment.phone_tier`."
            )
    return found


def _singular(tier: str) -> str:
    return tier[:-1] if tier.endswith("s") and len(tier) > 1 else tier


def _is_of(name: str, tier: str, other: str) -> bool:
    return _singular(tier) in name and _singular(other) not in name


def probe(files: LabelFiles, settings: AlignmentSettings, utterances: Sequence[Utterance], usable, most: int) -> None:
    """Check before any job that the files of some utterances can be used.

    Parameters
    ----------
    usable : function of :class:`Given` that raises :class:`RejectedUtterance` where its labels cannot be used
    most : number of utterances that are tried, evenly spread over the corpus

    Raises
    ------
    SettingError
        Those of none can; the message is that of the first.
    CorpusError
        A CTM file, all of which is read, is none.
    """
    able = [one for one in utterances if not one.problem and not files.utterances[one.id].problem]
    tried = able[:: max(1, len(able) // most)][:most]
    reader = LabelReader(files.part([one.id for one in tried]), settings)
    first: RejectedUtterance | None = None
    for one in tried:
        try:
            usable(reader.read(one))
            return
        except RejectedUtterance as error:
            first = first or error
    if first is not None:
        raise SettingError(
            f"none of {len(tried)} alignments in {files.folder} that were tried can be used. That of {tried[0].id}: "
            f"{first.reason}. {first.remedy}"
        )
