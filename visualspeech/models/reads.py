"""The entries of ``reads:``: an input block, or an input block with a window of frames; for planning."""

from collections.abc import Mapping, Sequence

from visualspeech.fields import shortened
from visualspeech.models.rows import MAX_WINDOW
from visualspeech.schema import mistakes

_SECONDS = {
    "type": "number",
    "exclusiveMinimum": 0,
    "maximum": MAX_WINDOW,
    "description": "Window in seconds before and after a frame.",
}


def read_mistakes(reads: Sequence, where: str) -> list[str]:
    """What is wrong with the form of the entries of ``reads:``; their names are judged elsewhere.

    Parameters
    ----------
    reads : names of blocks, and mappings of one name to seconds
    where : place of ``reads`` in the settings, for messages
    """
    found = []
    for number, one in enumerate(reads):
        if not isinstance(one, Mapping):
            continue
        if len(one) != 1:
            example = "{name: 0.16}"
            found.append(
                f"`{where}.{number}: {shortened(dict(one))}` must be one input block with its window in seconds before "
                f"and after a frame, for example {example}."
            )
            continue
        found += mistakes(one, {"type": "object", "additionalProperties": _SECONDS}, f"{where}.{number}")
    return found


def read_names(reads: Sequence) -> list:
    """The blocks of well-formed entries, in their order."""
    return [next(iter(one)) if isinstance(one, Mapping) else one for one in reads]


def read_windows(reads: Sequence) -> dict[str, float]:
    """Seconds before and after a frame by block, of the entries that have a window."""
    return {name: float(seconds) for one in reads if isinstance(one, Mapping) for name, seconds in one.items()}
