"""The visual coding of the kind ``markers``: normalised coordinates of the markers of a face, in regions.

Sadoughi and Busso (2017, section 3.2) normalise the coordinates of each subject to zero mean and unit deviation. Here
this is the coding, so that models predict normalised values and errors are of normalised values, as in their Table 1.
There are no components: a vector holds the d coordinates of each of P markers in turn.
"""

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from visualspeech.errors import DamagedFile, DataError
from visualspeech.face.markers import MAX_MARKERS, MAX_NAME, REGIONS, MarkerSet
from visualspeech.fields import Settings, restored, setting
from visualspeech.storage import regions as stored_regions
from visualspeech.storage.layouts import TEXT, Array, FileLayout
from visualspeech.storage.models import read_model_of, write_model

KIND = "markers"
#: A coordinate whose deviation is below this share of the largest one does not move; it is centred, but not scaled.
STILL = 1e-4


@dataclass(frozen=True)
class MarkerSettings(Settings):
    """Normalisation of the coordinates of markers."""

    section = "markers"
    normalisation: str = setting(
        "speaker",
        "Mean and deviation of each coordinate: of the speaker's training utterances, or of those of the whole corpus.",
        choices=("speaker", "corpus"),
    )


@dataclass(frozen=True)
class MarkerCoding:
    """A trained visual coding of P markers with d coordinates, N = P d (:mod:`visualspeech.face.coding`).

    Parameters
    ----------
    markers : names and regions of the markers
    dimensions : d
    source : name of the marker set, or of the corpus that gives it
    speakers : (S,) speakers with statistics of their own
    mean, deviation : (S + 1, N) float32 of each speaker, and of all training utterances together in the last row, which
        stands for speakers without any
    settings : the settings it was trained with
    """

    markers: MarkerSet
    dimensions: int
    source: str
    speakers: tuple[str, ...]
    mean: np.ndarray
    deviation: np.ndarray
    settings: MarkerSettings

    @property
    def size(self) -> int:
        """N, the number of values per frame."""
        return self.markers.size * self.dimensions

    @property
    def points(self) -> None:
        """No point set."""
        return None

    @property
    def regions(self) -> dict[str, tuple[int, ...]]:
        """Region of the face -> its columns."""
        return self.markers.columns(self.dimensions)

    def encode(self, points: np.ndarray, speaker: str) -> np.ndarray:
        """Normalised vectors (T, N) float32 of points (T, P, d) in the order of the marker set.

        Raises
        ------
        DataError
            The points have another shape.
        """
        mean, deviation = self._statistics(speaker)
        return (flat(points, self.markers.size, self.dimensions) - mean) / deviation

    def decode_points(self, parameters: np.ndarray, speaker: str = "") -> np.ndarray:
        """The inverse of :meth:`encode`: points (T, P, d) float32 in the unit of the recordings, of vectors (T, N)."""
        mean, deviation = self._statistics(speaker)
        values = np.asarray(parameters, np.float32) * deviation + mean
        return values.reshape(len(values), self.markers.size, self.dimensions)

    def _statistics(self, speaker: str) -> tuple[np.ndarray, np.ndarray]:
        row = self.speakers.index(speaker) if speaker in self.speakers else len(self.speakers)
        return self.mean[row], self.deviation[row]

    def save(self, path: str | Path) -> None:
        """Write the coding as safetensors."""
        plain = {
            "kind": KIND,
            "points": self.source,
            "sizes": {"appearance": self.size},
            "dimensions": self.dimensions,
            "regions": self.markers.by_region(),
            stored_regions.COLUMNS: {region: list(columns) for region, columns in self.regions.items()},
            "names": list(self.markers.names),
            "speakers": list(self.speakers),
            "settings": asdict(self.settings),
        }
        write_model(path, {"mean": self.mean, "deviation": self.deviation}, plain)

    @classmethod
    def load(cls, path: str | Path) -> "MarkerCoding":
        """Read what :meth:`save` wrote; raises as :func:`visualspeech.storage.models.read_model_of`."""
        tensors, stored = read_model_of(path, "visual coding of markers", [KIND], LAYOUT)
        names, speakers = tuple(stored["names"]), tuple(stored["speakers"])
        known = {name: number for number, name in enumerate(names)}
        given = stored["regions"]
        if not all(name in known for region in given.values() for name in region):
            raise DamagedFile(path, "its regions name markers that it has not")
        try:
            markers = MarkerSet(names, {region: tuple(known[one] for one in given[region]) for region in given})
        except DataError as error:
            raise DamagedFile(path, str(error)) from error
        shape = (len(speakers) + 1, markers.size * stored["dimensions"])
        if tensors["mean"].shape != shape:
            raise DamagedFile(path, f"its means have the shape {tensors['mean'].shape}, not {shape}")
        columns = {region: tuple(one) for region, one in stored[stored_regions.COLUMNS].items()}
        if columns != markers.columns(stored["dimensions"]):
            raise DamagedFile(path, "the columns of its regions are not those of its markers")
        if len(set(speakers)) < len(speakers):
            raise DamagedFile(path, "a speaker occurs twice")
        settings = restored(MarkerSettings, stored["settings"], path)
        statistics = {name: np.asarray(values, np.float32) for name, values in tensors.items()}
        return cls(markers, stored["dimensions"], stored["points"], speakers, settings=settings, **statistics)


_NAMES = {"type": "array", "maxItems": MAX_MARKERS, "items": {"type": "string", "maxLength": MAX_NAME}}
#: S + 1 rows of statistics, N values per frame.
LAYOUT = FileLayout(
    {"mean": Array("f", ("S", "N"), -1e9, 1e9), "deviation": Array("f", ("S", "N"), 1e-12, 1e9)},
    {
        "points": TEXT,
        "sizes": {"type": "object"},
        "dimensions": {"type": "integer", "minimum": 1, "maximum": 3},
        "regions": {"type": "object", "additionalProperties": False, "properties": dict.fromkeys(REGIONS, _NAMES)},
        stored_regions.COLUMNS: stored_regions.LAYOUT,
        "names": {**_NAMES, "minItems": 1},
        "speakers": {"type": "array", "maxItems": 100_000, "items": TEXT},
        "settings": {"type": "object"},
    },
)


def flat(points: np.ndarray, markers: int, dimensions: int) -> np.ndarray:
    """Points (T, P, d) as vectors (T, P d) float32.

    Raises
    ------
    DataError
        They have another shape.
    """
    points = np.asarray(points, np.float32)
    if points.shape[1:] != (markers, dimensions):
        raise DataError(f"expected {markers} markers of {dimensions} coordinates, got points {points.shape}")
    return points.reshape(len(points), markers * dimensions)


class _Moments(NamedTuple):
    """Number of frames, mean (N,) and sum of squared deviations from it (N,), of some frames; float64."""

    count: int
    mean: np.ndarray
    squares: np.ndarray

    @classmethod
    def of(cls, values: np.ndarray) -> "_Moments":
        mean = values.mean(axis=0, dtype=np.float64)
        return cls(len(values), mean, np.square(values - mean).sum(axis=0))

    def __add__(self, other: "_Moments") -> "_Moments":
        """The moments of both together (Chan, Golub and LeVeque 1983, Eq. 2.1)."""
        count = self.count + other.count
        away = other.mean - self.mean
        squares = self.squares + other.squares + away**2 * (self.count * other.count / count)
        return _Moments(count, self.mean + away * (other.count / count), squares)

    def deviation(self) -> np.ndarray:
        """Standard deviation (N,); 1 where a coordinate does not move."""
        found = np.sqrt(self.squares / self.count)
        return np.where(found > STILL * found.max(), found, 1.0)


def fit(
    recorded: Iterable[tuple[str, np.ndarray]],
    markers: MarkerSet,
    source: str = "",
    settings: MarkerSettings | None = None,
) -> MarkerCoding:
    """Train a :class:`MarkerCoding` on training utterances, read in one pass.

    Parameters
    ----------
    recorded : speaker and points (T, P, d) of each utterance, in the order of the marker set
    source : name of the marker set

    Raises
    ------
    DataError
        There are none, they have no frames, differ in shape, or hold values that are not finite.
    """
    settings = settings or MarkerSettings()
    by_speaker: dict[str, _Moments] = {}
    dimensions = 0
    for speaker, points in recorded:
        dimensions = dimensions or points.shape[-1]
        values = flat(points, markers.size, dimensions)
        if not len(values) or not np.isfinite(values).all():
            raise DataError(f"an utterance of {speaker} has no frames, or points that are not finite")
        found = _Moments.of(values)
        by_speaker[speaker] = by_speaker[speaker] + found if speaker in by_speaker else found
    if not by_speaker:
        raise DataError("no training utterances to take the statistics of markers of")
    ordered = sorted(by_speaker)
    every = by_speaker[ordered[0]]
    for speaker in ordered[1:]:
        every = every + by_speaker[speaker]
    own = ordered if settings.normalisation == "speaker" else []
    rows = [*(by_speaker[speaker] for speaker in own), every]
    return MarkerCoding(
        markers=markers,
        dimensions=dimensions,
        source=source,
        speakers=tuple(own),
        mean=np.stack([one.mean for one in rows]).astype(np.float32),
        deviation=np.stack([one.deviation() for one in rows]).astype(np.float32),
        settings=settings,
    )
