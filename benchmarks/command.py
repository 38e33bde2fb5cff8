"""How every benchmark starts: ``--help``, arguments by the signature of its ``main``, messages without a traceback."""

import inspect
import sys
from collections.abc import Callable
from pathlib import Path

from tests.paths import grid_root
from visualspeech.errors import CorpusError, VisualSpeechError


def run_main(main: Callable[..., int | None], description: str) -> None:
    """Call ``main`` with the arguments of the command line and exit with the status that it returns (None is 0).

    Each argument is converted to the type that ``main`` names for its parameter. ``--help`` prints the description.
    """
    given = sys.argv[1:]
    if "--help" in given or "-h" in given:
        print(description.strip())
        return
    try:
        arguments = converted(main, given)
    except (TypeError, ValueError) as error:
        print(f"{description.strip()}\n\nwrong arguments: {error}", file=sys.stderr)
        sys.exit(2)
    try:
        status = main(*arguments)
    except VisualSpeechError as error:
        sys.exit(str(error))
    sys.exit(status)


def converted(main: Callable, given: list[str]) -> list:
    """Arguments as ``main`` takes them.

    Raises
    ------
    TypeError
        There are too few or too many.
    ValueError
        One is not of the type of its parameter.
    """
    signature = inspect.signature(main)
    signature.bind(*given)
    parameters = list(signature.parameters.values())
    # Further arguments belong to the last parameter, where that takes any number.
    kinds = [parameters[min(number, len(parameters) - 1)].annotation for number in range(len(given))]
    return [kind(text) for kind, text in zip(kinds, given, strict=True)]


def grid() -> Path:
    """Root of the copy of GRID.

    Raises
    ------
    CorpusError
        There is none.
    """
    root = grid_root()
    if root is None:
        raise CorpusError("no copy of GRID found: set GRID_ROOT to the folder that holds s1/ and alignments/.")
    return root
