"""Findings about utterances: the record, its table, the limit at which a corpus is refused, and how they arise.

:func:`attempt` is the one place where what fails for an utterance is told from what fails for a run.
"""

import errno
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, fields

from visualspeech.corpora.records import Utterance
from visualspeech.corpora.split import SPLITS
from visualspeech.errors import CorpusError, RejectedUtterance, SettingError, StorageError, VisualSpeechError
from visualspeech.jobs import log_defect
from visualspeech.storage.tables import read_table, write_table

REJECT, WARN = "reject", "warn"
#: Begins the finding of words whose pronunciation is guessed, which follow with commas between them.
UNLISTED = "not in the pronunciation dictionary: "
#: What concerns the run, not one utterance. A full disk is an :class:`OSError`, see :func:`attempt`.
OF_THE_RUN = (StorageError, SettingError, CorpusError, MemoryError)
FULL_DISK = (errno.ENOSPC, errno.EDQUOT)
MAX_REASON = 200  # characters of the message of an unexpected error


@dataclass(frozen=True)
class Finding:
    """A problem found with one utterance.

    Parameters
    ----------
    id : of the utterance
    stage : of the workflow (check, alignment, landmarks, pose, motion, textures, fitting)
    level : ``reject`` (the run continues without the utterance) or ``warn`` (the utterance is used)
    file : path of the file concerned
    finding : the problem
    remedy : what the user can do about it
    """

    id: str
    stage: str
    level: str
    file: str
    finding: str
    remedy: str = ""


def rejection(utterance_id: str, stage: str, file: str, error: RejectedUtterance) -> Finding:
    """The finding of a :class:`RejectedUtterance`."""
    return Finding(utterance_id, stage, REJECT, file, error.reason, error.remedy)


@dataclass(frozen=True)
class Outcome:
    """What became of one utterance in one stage.

    Parameters
    ----------
    value : what was computed; None if the utterance is rejected
    rejected : why the utterance cannot be used; None if it can
    findings : the rejection, or nothing
    """

    value: object = None
    rejected: RejectedUtterance | None = None
    findings: tuple[Finding, ...] = ()


def attempt(utterance: Utterance, stage: str, function: Callable, *args, **kwargs) -> Outcome:
    """Compute something of one utterance; whatever goes wrong with it is a rejection and does not stop the run.

    The function must consume lazily decoded frames itself. The traceback of an unexpected error goes to the log file.

    Raises
    ------
    StorageError, SettingError, CorpusError, MemoryError
        From the function: these concern the whole run, as does an :class:`OSError` of a full disk.
    """
    try:
        return Outcome(function(*args, **kwargs))
    except OF_THE_RUN:
        raise
    except RejectedUtterance as error:
        rejected = error
    except VisualSpeechError as error:
        rejected = RejectedUtterance(str(error), "Copy or convert the recording again, or leave the utterance out.")
    except Exception as error:
        if isinstance(error, OSError) and error.errno in FULL_DISK:
            raise
        message = " ".join(f"{type(error).__name__}: {error}".split())[:MAX_REASON]
        log_defect(f"{utterance.id} is left out: unexpected error: {message}", error)
        rejected = RejectedUtterance(
            f"unexpected error: {message}",
            "Convert the recording again, or leave the utterance out. The log of this stage holds the details.",
        )
    return Outcome(rejected=rejected, findings=(rejection(utterance.id, stage, utterance.file, rejected),))


@contextmanager
def needed(utterance: Utterance) -> Iterator[None]:
    """Compute something that cannot do without this utterance.

    Raises
    ------
    CorpusError
        Its recording cannot be used; the message names the file.
    """
    try:
        yield
    except RejectedUtterance as error:
        raise CorpusError(f"{utterance.file}: {error.reason}. {error.remedy}") from error


def write_findings(path, findings: Iterable[Finding]) -> None:
    """Write findings as a table: rejections before warnings, each sorted by utterance."""
    import pandas

    ordered = sorted(findings, key=lambda one: (one.level != REJECT, one.id, one.stage, one.finding))
    columns = [field.name for field in fields(Finding)]
    write_table(path, pandas.DataFrame([asdict(one) for one in ordered], columns=columns))


def read_findings(*paths) -> list[Finding]:
    """The findings of several tables, in their order."""
    names = tuple(field.name for field in fields(Finding))
    tables = (read_table(path, names, required=names)[list(names)] for path in paths)
    return [Finding(*row) for table in tables for row in table.itertuples(index=False)]


def rejected_ids(findings: Iterable[Finding]) -> set[str]:
    """Ids of the rejected utterances."""
    return {one.id for one in findings if one.level == REJECT}


def check_share(findings: Iterable[Finding], utterances: int, limit: float) -> None:
    """Refuse a corpus with too many rejected utterances.

    Parameters
    ----------
    utterances : number of utterances in the corpus
    limit : largest share of them that may be rejected

    Raises
    ------
    CorpusError
        More than this share, or all utterances, are rejected; the message gives the first reasons.
    """
    rejections = [one for one in findings if one.level == REJECT]
    count = len({one.id for one in rejections})
    if count and (count > limit * utterances or count == utterances):
        first = "\n".join(f"  {one.file or one.id}: {one.finding}. {one.remedy}" for one in rejections[:10])
        raise CorpusError(
            f"{count} of {utterances} utterances cannot be used, more than the share `max_rejected_share: {limit:g}`:\n"
            f"{first}\nFix the recordings, or raise the share to continue without them."
        )


def check_splits(utterances: Iterable[Utterance]) -> None:
    """Refuse a corpus of which a whole split was rejected.

    Raises
    ------
    CorpusError
        None of these utterances is in one of the splits.
    """
    left = {one.split for one in utterances}
    empty = [name for name in SPLITS if name not in left]
    if empty:
        raise CorpusError(
            f"no utterance of the split {', '.join(map(repr, empty))} can be used. Fix the recordings that the "
            "findings name, or add recordings."
        )
