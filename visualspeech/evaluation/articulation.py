"""Articulation: whether the lips close where they must, and how the opening of the mouth follows that of the recording.

All measures are computed from decoded points (:func:`visualspeech.face.lips.lip_opening`), so they hold for every
visual coding, and they are absolute: the mean of an utterance is not removed. A prediction is decoded with the
reference face of the corpus and compared with the tracked points of the recording, moved onto the same reference face.

*Closure.* The least opening within an occurrence of a phone (:mod:`visualspeech.speech.closures`) is compared with a
threshold: the 90th percentile of the same quantity over all occurrences of the class of phones (:data:`CLOSURES`) in
the recorded training utterances. A speaker whose recordings were scored in this way would have a closure rate of about
0.9. A mouth that hardly moves can close as often, so open vowels are counted too: the greatest opening within one is
compared with the 10th percentile of the recorded training occurrences.

*Opening over time.* Correlation and standard-deviation ratio are those of all frames. The lag is the position of the
maximum of the cross-correlation of both openings, each less its mean over the utterance.

As in :mod:`visualspeech.evaluation.metrics`, statistics of utterances are sums from which the figures of a corpus
follow.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from visualspeech.errors import DamagedFile, DataError
from visualspeech.evaluation.metrics import ABSOLUTE, Metric, quotient
from visualspeech.face.lips import has_inner_lips, lip_opening
from visualspeech.face.point_sets import to_points
from visualspeech.speech.alignment import Alignment
from visualspeech.speech.closures import CLOSURES, OPEN, OPEN_VOWELS, greatest_openings, least_openings
from visualspeech.storage.tables import read_table, write_table

PERCENTILE = 90
#: Class of phones -> the phones as they are named in tables.
TARGETS = {**CLOSURES, OPEN: ", ".join(sorted(OPEN_VOWELS))}
MAX_LAG = 0.2  # seconds
LAGS = np.arange(-20, 21) * (MAX_LAG / 20)  # positive: the prediction comes after the recording
_CONSTANT = 1e-9  # of the mean square: less variance than this is rounding


@dataclass(frozen=True)
class Target:
    """What counts as closed for a class of phones, or as open for open vowels.

    Parameters
    ----------
    name : class of phones, a key of :data:`TARGETS`
    threshold : largest opening that counts as closed, or least one that counts as open, in pixels of the normalised
        face; NaN without occurrences
    occurrences : number of training occurrences that it was taken from
    """

    name: str
    threshold: float
    occurrences: int

    def reached(self, openings: np.ndarray) -> np.ndarray:
        """Whether the openings (n,) of :func:`openings_of` reach the target."""
        return openings >= self.threshold if self.name == OPEN else openings <= self.threshold


def openings_of(opening: np.ndarray, alignment: Alignment, rate: float, name: str) -> np.ndarray:
    """Least opening in each occurrence of a class of phones, of open vowels the greatest, (n,)."""
    if name == OPEN:
        return greatest_openings(opening, alignment, rate)
    return least_openings(opening, alignment, rate, name)


def targets_of(recorded: Iterable[tuple[np.ndarray, Alignment, float]]) -> tuple[Target, ...]:
    """The thresholds of a speaker.

    Parameters
    ----------
    recorded : opening (T,), alignment and frame rate in Hz of each training utterance
    """
    found: dict[str, list[np.ndarray]] = {name: [] for name in TARGETS}
    for utterance in recorded:
        for name, values in found.items():
            values.append(openings_of(*utterance, name))
    whole = {name: np.concatenate(values) if values else np.zeros(0) for name, values in found.items()}
    return tuple(Target(name, _threshold(name, values), len(values)) for name, values in whole.items())


def _threshold(name: str, values: np.ndarray) -> float:
    if not len(values):
        return float("nan")
    return float(np.percentile(values, 100 - PERCENTILE if name == OPEN else PERCENTILE))


def write_targets(path, targets: Iterable[Target]) -> None:
    """Write thresholds as a table with the columns name, threshold (pixels) and occurrences."""
    import pandas

    write_table(path, pandas.DataFrame([vars(one) for one in targets], columns=["name", "threshold", "occurrences"]))


def read_targets(path) -> tuple[Target, ...]:
    """Read what :func:`write_targets` wrote.

    Raises
    ------
    StorageError
        The file is missing, or not such a table.
    """
    table = read_table(path, ("name",), ("threshold", "occurrences"), ("name",))
    if list(table["name"]) != list(TARGETS):
        raise DamagedFile(path, f"it must have a row for each of {', '.join(TARGETS)}")
    return tuple(Target(one.name, float(one.threshold), int(one.occurrences)) for one in table.itertuples(index=False))


def articulation(
    predicted: np.ndarray, true: np.ndarray, alignment: Alignment, rate: float, targets: Iterable[Target]
) -> dict[str, float]:
    """Statistics of one utterance: the columns that the measures of :data:`ARTICULATION` need.

    Parameters
    ----------
    predicted, true : opening (T,) of prediction and recording in pixels of the normalised face
    targets : from :func:`targets_of`

    Raises
    ------
    DataError
        The lengths differ, or there are no frames.
    """
    if not (0 < len(predicted) == len(true)):
        raise DataError(f"the predicted opening has {len(predicted)} frames, the recorded one {len(true)}.")
    found: dict[str, float] = {}
    for one in targets:
        for prefix, opening in (("", predicted), ("recorded_", true)):
            values = openings_of(opening, alignment, rate, one.name)
            found[f"{prefix}{one.name}_reached"] = float(np.count_nonzero(one.reached(values)))
        found[f"{one.name}_occurrences"] = float(len(values)) if one.occurrences else 0.0
    x, y = np.asarray(predicted, np.float64), np.asarray(true, np.float64)
    moments = (np.full(len(x), 1.0), x, y, x * x, y * y, x * y)
    found |= {f"opening.{number}": float(values.sum()) for number, values in enumerate(moments)}
    return found | {f"lag.{number}": float(value) for number, value in enumerate(cross_correlation(x, y, rate))}


def articulation_of(appearance: np.ndarray, recorded: np.ndarray, coding, *spoken) -> dict[str, float]:
    """Statistics of one utterance from parameters of a visual coding; none where the coding has no inner lips.

    Parameters
    ----------
    appearance : (T, N) predicted parameters
    recorded : (T, 2P) shape vectors of the recording, moved onto the reference face of the corpus
    coding : :class:`visualspeech.face.coding.VisualCoding`
    spoken : alignment, rate and targets, as :func:`articulation` takes them
    """
    if not has_inner_lips(coding.points):
        return {}
    faces = coding.decode_points(appearance), to_points(recorded)
    return articulation(*(lip_opening(points, coding.points) for points in faces), *spoken)


def cross_correlation(x: np.ndarray, y: np.ndarray, rate: float) -> np.ndarray:
    """Sums over frames of x(t + lag) y(t), each less its mean, at :data:`LAGS`, (41,).

    At lags of whole frames each sum is scaled to the number of frames, since fewer frames overlap at longer lags;
    between them it is interpolated by cubic splines. Frame rates can therefore differ between utterances. All are zero
    where an opening is constant, or shorter than all lags.

    Parameters
    ----------
    x, y : (T,) at ``rate`` Hz
    """
    from scipy.interpolate import CubicSpline

    deviations = [values - values.mean() for values in (x, y)]
    flat = [np.sum(d**2) <= _CONSTANT * np.sum(values**2) for d, values in zip(deviations, (x, y), strict=True)]
    frames, reach = len(x), int(np.ceil(MAX_LAG * rate)) + 2
    if any(flat) or frames <= reach:
        return np.zeros(len(LAGS))
    first, second = deviations
    shifts = np.arange(-reach, reach + 1)
    sums = np.array(
        [first[max(0, k) : frames + min(0, k)] @ second[max(0, -k) : frames - max(0, k)] for k in shifts.tolist()]
    )
    return CubicSpline(shifts / rate, sums * frames / (frames - np.abs(shifts)))(LAGS)


def _moments(sums: np.ndarray) -> tuple[np.ndarray, ...]:
    """Variances of x and y and their covariance from the sums of 1, x, y, x^2, y^2 and x y, (..., 6) -> three (...)."""
    with np.errstate(divide="ignore", invalid="ignore"):
        x, y, xx, yy, xy = (sums[..., number] / sums[..., 0] for number in range(1, 6))
    variances = (np.where(square - mean**2 > _CONSTANT * square, square - mean**2, 0.0)
                 for mean, square in ((x, xx), (y, yy)))  # fmt: skip
    return (*variances, xy - x * y)


def opening_correlation(sums: np.ndarray) -> np.ndarray:
    """Pearson correlation of two openings, (..., 6) -> (...); NaN where one is constant."""
    x, y, xy = _moments(sums)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where((x > 0) & (y > 0), np.clip(xy / np.sqrt(x * y), -1, 1), np.nan)


def opening_deviation(sums: np.ndarray) -> np.ndarray:
    """Standard deviation of the first opening over that of the second, (..., 6) -> (...); NaN for a constant second."""
    x, y, _ = _moments(sums)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(y > 0, np.sqrt(x / y), np.nan)


def opening_lag(sums: np.ndarray) -> np.ndarray:
    """Lag in milliseconds at which the cross-correlation is largest, (..., 41) -> (...).

    Between the lags by a parabola through the maximum and its neighbours; NaN where the maximum is at an end, or the
    correlation is nowhere positive.
    """
    best = np.clip(np.argmax(sums, axis=-1), 1, sums.shape[-1] - 2)
    before, at, after = (np.take_along_axis(sums, (best + k)[..., None], axis=-1)[..., 0] for k in (-1, 0, 1))
    curvature = before - 2 * at + after
    with np.errstate(divide="ignore", invalid="ignore"):
        moved = 0.5 * (before - after) / curvature
    inside = (at > 0) & (at >= before) & (at >= after) & (curvature < 0)
    return np.where(inside, 1000 * (LAGS[best] + moved * (LAGS[1] - LAGS[0])), np.nan)


def _closure(name: str) -> Metric:
    phones = TARGETS[name]
    return Metric(
        f"closure_{name}",
        f"Closure of {phones}",
        f"share of the occurrences of {phones} in which the least opening of the lips is at most the {PERCENTILE}th "
        "percentile of the recorded training occurrences",
        "high",
        (f"{name}_reached", f"{name}_occurrences"),
        protocol=ABSOLUTE,
    )


ARTICULATION: dict[str, Metric] = {
    metric.name: metric
    for metric in (
        *map(_closure, CLOSURES),
        Metric(
            "open_vowels",
            "Open vowels",
            f"share of the occurrences of {TARGETS[OPEN]} in which the greatest opening of the lips is at least the "
            f"{100 - PERCENTILE}th percentile of the recorded training occurrences: low for a mouth that hardly moves",
            "high",
            ("open_reached", "open_occurrences"),
            protocol=ABSOLUTE,
        ),
        Metric(
            "opening_corr",
            "Opening: correlation",
            "correlation over all frames of the opening of the lips, predicted and recorded",
            "high",
            ("opening",),
            opening_correlation,
            protocol=ABSOLUTE,
        ),
        Metric(
            "opening_sd",
            "Opening: deviation ratio",
            "standard deviation over all frames of the opening of the lips: predicted divided by recorded",
            "one",
            ("opening",),
            opening_deviation,
            protocol=ABSOLUTE,
        ),
        Metric(
            "opening_lag",
            "Opening: lag",
            "time by which the predicted opening comes after the recorded one, at the maximum of their "
            f"cross-correlation within {1000 * MAX_LAG:g} ms",
            "zero",
            ("lag",),
            opening_lag,
            unit="ms",
            protocol=ABSOLUTE,
        ),
    )
}


#: Measures of which the recorded faces have figures too: name of the measure -> class of phones.
OF_RECORDINGS = {**{f"closure_{name}": name for name in CLOSURES}, "open_vowels": OPEN}


def recorded_figures(table) -> Mapping[str, float]:
    """The measures :data:`OF_RECORDINGS` of the recorded faces of the same utterances; NaN without occurrences."""
    sums = {key: (table[f"recorded_{name}_reached"].sum(), table[f"{name}_occurrences"].sum())
            for key, name in OF_RECORDINGS.items()}  # fmt: skip
    return {key: float(quotient(np.array(pair))) for key, pair in sums.items()}
