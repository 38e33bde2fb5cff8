"""CTM files of Kaldi and of the Montreal Forced Aligner: ``utterance channel start duration label [score]``."""

import math
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path

from visualspeech.corpora.records import displayable
from visualspeech.errors import CorpusError, RejectedUtterance, plain_reason
from visualspeech.speech.given import EDIT, Given, Interval

MAX_LINE = 10_000  # bytes
_FIELDS = (5, 6)


class CtmFiles:
    """Words and phones of some utterances from CTM files, each of any number of utterances.

    The files are read once, line by line, and only the lines of the wanted utterances are kept.

    Parameters
    ----------
    words, phones : paths of the files
    wanted : names of utterances in the files
    word_tier, phone_tier : what the tiers are called in messages

    Raises
    ------
    CorpusError
        A file cannot be read, or is no CTM file.
    """

    def __init__(
        self,
        words: Collection[str | Path],
        phones: Collection[str | Path],
        wanted: Collection[str],
        word_tier: str = "words",
        phone_tier: str = "phones",
    ) -> None:
        self._tiers = (word_tier, phone_tier)
        self._words, self._phones = (_read(paths, frozenset(wanted)) for paths in (words, phones))

    def has(self, name: str) -> bool:
        """Whether a line of the files is of an utterance."""
        return name in self._words or name in self._phones

    def given(self, name: str) -> Given:
        """The intervals of an utterance.

        Raises
        ------
        RejectedUtterance
            The files do not have it, a time is no number, or a duration is not above 0.
        """
        found = []
        for tier, lines in zip(self._tiers, (self._words, self._phones), strict=True):
            if name not in lines:
                raise RejectedUtterance(
                    f"the CTM files of {tier} have no utterance {name!r}",
                    "Align it, or leave it out; utterances are named by the file, or by the id.",
                )
            found.append(tuple(sorted((_interval(*one) for one in lines[name]), key=lambda one: one.start)))
        return Given(name, *found, word_tier=self._tiers[0], phone_tier=self._tiers[1])


def _read(paths: Collection[str | Path], wanted: Collection[str]) -> Mapping[str, list[tuple[str, list[str]]]]:
    """Position in the files and fields of each line, by utterance."""
    found: dict[str, list[tuple[str, list[str]]]] = {}
    for path in paths:
        for number, fields in ctm_lines(path):
            if fields[0] in wanted:
                found.setdefault(fields[0], []).append((f"{displayable(Path(path).name)}, line {number}", fields))
    return found


def ctm_lines(path: str | Path) -> Iterator[tuple[int, list[str]]]:
    """Number and fields of each line of a CTM file; comments (``;;``) and empty lines are passed over.

    Raises
    ------
    CorpusError
        It cannot be read, is no UTF-8 text, or a line has too few or too many fields.
    """
    try:
        with open(path, "rb") as file:
            for number, line in enumerate(iter(lambda: file.readline(MAX_LINE + 1), b""), 1):
                where = f"the CTM file {displayable(str(path))}, line {number}"
                if len(line) > MAX_LINE:
                    raise CorpusError(f"{where} has more than {MAX_LINE:,} bytes; it is no CTM file.")
                fields = line.decode("utf-8-sig" if number == 1 else "utf-8").split()
                if not fields or fields[0].startswith(";;"):
                    continue
                if len(fields) not in _FIELDS:
                    raise CorpusError(
                        f"{where} has {len(fields)} fields. Write utterance, channel, start, duration and label, and "
                        "perhaps a score, separated by spaces."
                    )
                yield number, fields
    except UnicodeDecodeError as error:
        raise CorpusError(f"the CTM file {displayable(str(path))} is no UTF-8 text. Save it as UTF-8.") from error
    except OSError as error:
        raise CorpusError(f"the CTM file {displayable(str(path))} cannot be read: {plain_reason(error)}.") from error


def _interval(where: str, fields: list[str]) -> Interval:
    try:
        start, duration = float(fields[2]), float(fields[3])
    except ValueError:
        start = duration = math.nan
    if not (math.isfinite(start) and math.isfinite(duration)):
        raise RejectedUtterance(f"{where}: start and duration of {fields[4]!r} are no numbers", EDIT)
    return Interval(start, start + duration, fields[4])
