"""Findings about utterances: the record, its table, and the limit at which a corpus is refused."""

from collections.abc import Iterable
from dataclasses import asdict, dataclass, fields

from visualspeech.errors import CorpusError, RejectedUtterance
from visualspeech.storage.tables import read_table, write_table

REJECT, WARN = "reject", "warn"


@dataclass(frozen=True)
class Finding:
    """A problem found with one utterance.

    Parameters
    ----------
    id : of the utterance
    stage : of the workflow (check, alignment, landmarks, pose)
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
