"""The functions of the user's own measures: imported and called by the job that measures a model.

:mod:`visualspeech.planning.own_metrics` has found and described them.
"""

import importlib
import importlib.util
import sys
import traceback
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path

import numpy as np

from visualspeech.errors import DataError
from visualspeech.evaluation.scoring import centred
from visualspeech.face.point_sets import to_points


def with_own(
    rows: Iterable[dict], own: Mapping[str, Mapping], predictions, targets, coding, speakers: Mapping
) -> Iterator[dict]:
    """Rows of statistics, each with the figures of the user's own measures of its utterance.

    Parameters
    ----------
    rows : statistics of utterances, with ``id`` and ``rate``
    own : description of each measure by name
    predictions, targets : opened files with the array ``appearance``
    coding : decodes points, a :class:`visualspeech.face.coding.VisualCoding`
    speakers : utterance -> speaker

    Raises
    ------
    DataError
        A function cannot be imported, fails, or gives no finite number; the message names it, the utterance and the
        line of the source.
    """
    functions = {name: imported(name, described) for name, described in own.items()}
    asked = {one for described in own.values() for one in described["takes"]}
    for row in rows:
        given = _given(row["id"], asked, predictions, targets, coding, speakers[row["id"]]) if own else {}
        for name, function in functions.items():
            more = {one: given[one] for one in own[name]["takes"]}
            value = called(name, function, row["id"], given["predicted"], given["true"], more)
            row = row | {f"{name}_sum": value}
        yield row


def imported(name: str, described: Mapping) -> Callable:
    """The function of a measure, from the file that planning has read.

    Raises
    ------
    DataError
        The module fails while it is imported, or another module has its name.
    """
    root = str(Path(described["root"]).absolute())
    try:
        sys.path.insert(0, root)  # modules beside it come first while it is imported, and last when libraries import
        module = _module(described)
    except (Exception, SystemExit) as error:
        raise DataError(f"the measure `{name}` cannot be imported: {_said(error, described['file'])}") from error
    finally:
        sys.path.remove(root)
        sys.path.append(root)
    found = getattr(module, "__file__", None)
    if not found or Path(found).resolve() != Path(described["file"]).resolve():
        raise DataError(
            f"the measure `{name}` cannot be imported: Python finds {found or 'another module'} by the name "
            f"{described['module']}. Rename {described['file']}."
        )
    function = getattr(module, described["function"], None)
    if not callable(function):
        raise DataError(f"the measure `{name}` is no function after its module was imported. Define it with `def`.")
    return function


def _module(described: Mapping):
    """The module of a measure: a file by itself, of whatever name, or one of a package."""
    if "." in described["module"]:
        return importlib.import_module(described["module"])
    own = f"own_metrics_{described['module']}"
    spec = importlib.util.spec_from_file_location(own, Path(described["file"]).absolute())
    module = importlib.util.module_from_spec(spec)
    sys.modules[own] = module
    spec.loader.exec_module(module)
    return module


def called(name: str, function: Callable, utterance_id: str, predicted, true, more: Mapping) -> float:
    """The figure of one utterance.

    Raises
    ------
    DataError
        The function fails, or gives no finite number.
    """
    try:
        value = function(predicted, true, **more)
    except (Exception, SystemExit) as error:
        file = getattr(getattr(function, "__code__", None), "co_filename", "")
        raise DataError(f"the measure `{name}` failed on the utterance {utterance_id}: {_said(error, file)}") from error
    number = np.asarray(value) if isinstance(value, bool | int | float | np.ndarray | np.generic) else None
    if number is None or number.shape != () or number.dtype.kind not in "biuf":
        what = type(value).__name__ if number is None or number.shape == () else f"an array of shape {number.shape}"
        raise DataError(
            f"the measure `{name}` gave {what} for the utterance {utterance_id}; it must return one number."
        )
    if not np.isfinite(number):
        raise DataError(
            f"the measure `{name}` gave {float(number)} for the utterance {utterance_id}, {len(true)} frames; it must "
            "return a finite number of every utterance and row. Return 0 where it is undefined, as for the training "
            "mean, which never moves."
        )
    return float(number)


def _given(one: str, asked: set[str], predictions, targets, coding, speaker: str) -> dict:
    """What functions get of an utterance; arrays that cannot be changed, as all of them share these."""
    predicted, true = predictions.array(one, "appearance"), targets.array(one, "appearance")
    given = {"predicted": centred(predicted), "true": centred(true), "rate": float(targets.rate(one))}
    if "predicted_points" in asked:
        given["predicted_points"] = np.asarray(coding.decode_points(predicted, speaker), np.float64)
    if "true_points" in asked:
        tracked = coding.points is not None  # an appearance model keeps the tracked points beside its parameters
        points = to_points(targets.array(one, "points")) if tracked else coding.decode_points(true, speaker)
        given["true_points"] = np.asarray(points, np.float64)
    for value in given.values():
        if isinstance(value, np.ndarray):
            value.flags.writeable = False
    return given


def _said(error: BaseException, file: str) -> str:
    """What an exception says, with the last line of the user's file that led to it."""
    lines = [one.lineno for one in traceback.extract_tb(error.__traceback__) if _same(one.filename, file)]
    place = f" ({Path(file).name}, line {lines[-1]})" if lines else ""
    return f"{type(error).__name__}: {' '.join(str(error).split())[:300] or 'no message'}{place}."


def _same(one: str, other: str) -> bool:
    return bool(other) and Path(one).resolve() == Path(other).resolve()
