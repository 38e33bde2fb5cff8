"""What became of an attempt, and what is wrong with the way it was answered."""

import re
from collections.abc import Iterable
from dataclasses import dataclass

#: Words of a message that a user cannot read: names of exceptions and of Python's machinery.
_JARGON = re.compile(
    r"Traceback|\b[A-Z]\w+(Error|Exception)\b|codec can't|object has no|NoneType|positional argument|unexpected error"
)
_LONGEST = 1200  # characters of a line; of several mistakes each has its own
_MOST_LINES = 52


@dataclass(frozen=True)
class Result:
    """The answer to one attempt.

    Parameters
    ----------
    case : what was tried
    refused : whether it was refused; otherwise it was used
    said : the message, where there was one
    wrong : what is wrong with the answer; empty if nothing is
    """

    case: str
    refused: bool
    said: str = ""
    wrong: str = ""


def used(case: str, said: str = "", wrong: str = "") -> Result:
    """The result of an attempt that was accepted."""
    return Result(case, False, said, wrong)


def refused(case: str, said: str, names: Iterable[str] = ()) -> Result:
    """The result of an attempt that was refused with a message, which must name one of ``names``."""
    return Result(case, True, said, fault(said, names))


def fault(said: str, names: Iterable[str] = ()) -> str:
    """What is wrong with a message: it is missing, unreadable, too long, or names neither file nor key."""
    names = list(names)
    if not said.strip():
        return "refused without a message"
    if jargon := _JARGON.search(said):
        return f"a message for programmers ({jargon[0]}): {said[:300]}"
    lines = said.splitlines()
    if len(lines) > _MOST_LINES or max(map(len, lines)) > _LONGEST:
        return f"a message of {len(lines)} lines and {len(said)} characters: {said[:200]}"
    if names and not any(name in said for name in names):
        return f"the message names none of {names}: {said[:300]}"
    return ""
