"""The answered viewing tests that a run evaluates."""

import os
import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from visualspeech.errors import SettingError, VisualSpeechError, plain_reason
from visualspeech.study.records import ANSWERS, SIMULATED_ANSWERS, read_key, read_study

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,63}")


@dataclass(frozen=True)
class EvaluatedStudy:
    """A study whose answers a run evaluates.

    Parameters
    ----------
    corpus : that its videos show
    name : of the study
    folder : path as given
    """

    corpus: str
    name: str
    folder: str


def evaluated_studies(section: Mapping, corpora: Collection[str]) -> tuple[EvaluatedStudy, ...]:
    """The studies that ``study_evaluation.folders`` names, in its order.

    Parameters
    ----------
    section : settings ``study_evaluation``
    corpora : names of those of the run

    Raises
    ------
    SettingError
        A folder holds no study, or one of a corpus that is not run, or two hold one study; all mistakes at once.
    """
    found: dict[tuple[str, str], EvaluatedStudy] = {}
    mistakes = []
    for number, given in enumerate(section["folders"]):
        where = f"`study_evaluation.folders.{number}: {given}`"
        try:
            one = _evaluated(given)
        except VisualSpeechError as error:
            mistakes.append(f"{where}: {error}")
            continue
        if one.corpus not in corpora:
            mistakes.append(
                f"{where} is a study of the corpus {one.corpus}, which is not run (run: {', '.join(corpora)}); add the "
                "corpus to `corpora`, or leave the folder out."
            )
        elif (one.corpus, one.name) in found:
            mistakes.append(
                f"{where}: {found[one.corpus, one.name].folder} holds the study {one.name}, too; leave one out."
            )
        else:
            found[one.corpus, one.name] = one
    if mistakes:
        raise SettingError("\n".join(mistakes))
    return tuple(found.values())


def _evaluated(given: str) -> EvaluatedStudy:
    folder = os.path.expanduser(given)
    try:
        study, key = read_study(folder), read_key(folder)
    except OSError as error:
        raise SettingError(f"cannot be read ({plain_reason(error)}); give the folder of a study.") from error
    if not _NAME.fullmatch(study.name):
        raise SettingError(f"its name {study.name[:80]!r} must be letters, digits, - and _, at most 64.")
    return EvaluatedStudy(key.corpus, study.name, folder)


def answers_state(folder: str, simulated: bool) -> list:
    """What changes when answers are added, or the study is made again: sizes and times of modification of its files."""
    return [(path.name, *_state(path)) for path in _files(folder, simulated)]


def _files(folder: str, simulated: bool) -> Iterator[Path]:
    yield from (Path(folder, "study.json"), Path(folder, "key.json"))
    database = Path(folder, SIMULATED_ANSWERS if simulated else ANSWERS)
    yield database
    # A running server keeps the latest answers in a file beside the database.
    yield database.with_name(f"{database.name}-wal")


def _state(path: Path) -> tuple[int, int]:
    try:
        status = path.stat()
    except OSError:
        return 0, 0
    return status.st_size, status.st_mtime_ns
