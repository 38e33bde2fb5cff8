"""Makes the tracker that the settings name: one of this package, a class of the user's own, or the reader of CSV files.

The class of a user is code of the user, which a run imports because its settings say so. Nothing else names a module: a
corpus and a speaker folder, which may come from strangers, cannot.
"""

import importlib
import inspect
import os
import sys

import numpy as np

from visualspeech.errors import SettingError
from visualspeech.face.tracker import CSV_READER, POINTS, TRACKERS, LandmarkSettings, TrackedVideo, Tracker
from visualspeech.fields import shortened
from visualspeech.jobs import log_defect

_FORM = (
    "Write `Tracker.__init__(self, settings, video)` and `Tracker.next(self, frame, number)`: see docs/landmarks.md."
)


def tracker_name(settings: LandmarkSettings) -> str:
    """The class that gives the landmarks, as ``module:Class``."""
    return CSV_READER if settings.source == "csv" else TRACKERS.get(settings.tracker, settings.tracker)


def load_tracker(settings: LandmarkSettings, video: TrackedVideo, folder: str = "") -> Tracker:
    """The tracker of one utterance.

    Parameters
    ----------
    folder : in which a module of the user's own lies; empty: where Python finds modules

    Raises
    ------
    SettingError
        There is no such module or class, the module cannot be imported, or the class is no tracker.
    RejectedUtterance
        There are no landmarks of this recording, or they cannot be read.
    """
    name = tracker_name(settings)
    module, _, attribute = name.partition(":")
    if name in (CSV_READER, *TRACKERS.values()):
        return getattr(importlib.import_module(module), attribute)(settings, video)
    cls = getattr(_imported(module, folder, name), attribute, None)
    if cls is None:
        raise _mistake(name, f"the module {module} has no {attribute}. Name a class that is in it.")
    if not callable(cls):
        raise _mistake(name, f"{attribute} is no class. {_FORM}")
    _check_call(cls, (settings, video), name, f"{attribute}(settings, video)")
    tracker = cls(settings, video)
    if not callable(getattr(tracker, "next", None)):
        raise _mistake(name, f"{attribute} has no method `next`. {_FORM}")
    _check_call(tracker.next, (None, 0), name, f"{attribute}.next(frame, number)")
    return tracker


def checked_points(points, settings: LandmarkSettings, video: TrackedVideo, number: int) -> np.ndarray | None:
    """What a tracker returned for a frame as points (68, 2) float64; None where it found no face.

    Points of which one is not finite are no face.

    Raises
    ------
    SettingError
        The tracker returned something else.
    """
    if points is None:
        return None
    try:
        found = np.asarray(points, np.float64)
    except (TypeError, ValueError):
        found = None
    if found is None or found.shape != (POINTS, 2):
        what = f"a {type(points).__name__}" if found is None else f"an array of the shape {found.shape}"
        raise _mistake(
            settings.tracker,
            f"`next` returned {what} for frame {number} of {video.path or 'the recording'}. Return the points as an "
            f"array ({POINTS}, 2) in pixels, or None where there is no face.",
        )
    return found if np.isfinite(found).all() else None


def _imported(module: str, folder: str, name: str):
    if folder and folder not in sys.path:
        sys.path.append(folder)  # at the end: a module of the user must not hide one of Python's
    try:
        found = importlib.import_module(module)
    except ModuleNotFoundError as error:
        if error.name and (module == error.name or module.startswith(f"{error.name}.")):
            raise _mistake(
                name,
                f"there is no module {error.name}. Put it into the folder of the settings file or into the folder in "
                "which the run starts, or install it.",
            ) from error
        raise _failed(name, module, error) from error
    except (Exception, SystemExit) as error:
        raise _failed(name, module, error) from error
    place = os.path.realpath(getattr(found, "__file__", None) or "")
    if folder and not place.startswith(os.path.join(os.path.realpath(folder), "")):
        raise _mistake(name, f"Python has a module {module} of its own ({place}). Rename the file in {folder}.")
    return found


def _failed(name: str, module: str, error: BaseException) -> SettingError:
    log_defect(f"the module {module} of the landmark tracker cannot be imported", error)
    reason = shortened(" ".join(f"{type(error).__name__}: {error}".split()), 200)
    return _mistake(name, f"the module {module} cannot be imported ({reason}). Correct it.")


def _check_call(function, arguments: tuple, name: str, shown: str) -> None:
    try:
        inspect.signature(function).bind(*arguments)
    except TypeError as error:
        raise _mistake(name, f"`{shown}` cannot be called ({error}). {_FORM}") from error
    except ValueError:  # a class of C code does not tell its parameters
        return


def _mistake(name: str, what: str) -> SettingError:
    return SettingError(f"`landmarks.tracker: {shortened(name)}`: {what}")
