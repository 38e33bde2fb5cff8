"""Classes of gestures: k-means of their shapes, resampled to one length (Thangthai 2016, section 3)."""

import warnings
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from visualspeech.errors import DataError
from visualspeech.features.visemes.segmentation import Gestures, resampled, stretched

POINTS = 8  # times at which the shape of a gesture is taken
MAX_GESTURES = 50_000  # that k-means sees; of a larger corpus every second one, or fewer
ITERATIONS = 100


@dataclass(frozen=True)
class VisemeClasses:
    """N classes of gestures.

    Parameters
    ----------
    means : (N, points, D) float32, mean shape of each class
    counts : (N,) int64, training gestures of each class that the means were taken over
    """

    means: np.ndarray
    counts: np.ndarray

    def __len__(self) -> int:
        return len(self.means)

    def distances(self, shapes: np.ndarray) -> np.ndarray:
        """Squared distance (G, N) of shapes (G, points, D) to the means, per frame: the sum over D."""
        given = shapes.reshape(len(shapes), -1).astype(np.float64)
        means = self.means.reshape(len(self), -1).astype(np.float64)
        # Distances to a common centre, for parameters whose mean is far from 0.
        centre = means.mean(axis=0)
        given, means = given - centre, means - centre
        squares = np.square(given).sum(axis=1)[:, None] + np.square(means).sum(axis=1) - 2 * given @ means.T
        return np.maximum(squares, 0) / self.means.shape[1]

    def assign(self, values: np.ndarray, gestures: Gestures) -> np.ndarray:
        """Class (G,) int64 of each gesture of an utterance with the parameters ``values`` (T, D): the nearest mean."""
        return self.distances(resampled(values, gestures, self.means.shape[1])).argmin(axis=1)

    def reconstruct(self, classes: np.ndarray, gestures: Gestures) -> np.ndarray:
        """Parameters (T, D) of gestures of these classes: each mean, stretched to the length of its gesture."""
        return stretched(self.means[classes], gestures.lengths)


class ShapeSample:
    """Shapes of training gestures, thinned evenly so that their number stays bounded.

    Parameters
    ----------
    limit : more than this many are never given to k-means
    """

    def __init__(self, limit: int = MAX_GESTURES) -> None:
        self._limit, self._stride, self._kept, self._parts = limit, 1, 0, []
        self.gestures = 0

    def add(self, shapes: np.ndarray) -> None:
        """Enter the shapes (G, points, D) of one utterance."""
        chosen = shapes[-self.gestures % self._stride :: self._stride]
        self.gestures += len(shapes)
        self._parts.append(chosen)
        self._kept += len(chosen)
        while self._kept > self._limit:
            self._stride *= 2
            self._parts = [np.concatenate(self._parts)[::2]]
            self._kept = len(self._parts[0])

    def shapes(self) -> np.ndarray:
        """The shapes that are kept, (G, points, D), in the order in which they came."""
        return np.concatenate(self._parts) if self._parts else np.zeros((0, POINTS, 0), np.float32)


def fit_classes(shapes: Iterable[np.ndarray], classes: int, seed: int) -> VisemeClasses:
    """K-means (k-means++, one start) of the shapes of training gestures; the most frequent class is the first.

    Parameters
    ----------
    shapes : (G, points, D) of each training utterance
    classes : number N of classes

    Raises
    ------
    DataError
        There is no training utterance, or there are fewer gestures than classes.
    """
    from sklearn.cluster import KMeans
    from sklearn.exceptions import ConvergenceWarning

    sample = ShapeSample()
    for one in shapes:
        sample.add(one)
    given = sample.shapes()
    if not len(given):
        raise DataError("there is no training utterance to learn from. Add recordings, or change `split`.")
    if classes > len(given):
        raise DataError(
            f"`classes: {classes}` asks for more classes of dynamic visemes than there are gestures: the training "
            f"utterances have {len(given)}. Give at most that, better a tenth of it."
        )
    flat = given.reshape(len(given), -1)
    flat = flat - flat.mean(axis=0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)  # of gestures that are equal
        found = KMeans(classes, n_init=1, max_iter=ITERATIONS, random_state=seed).fit(flat).labels_
    counts = np.bincount(found, minlength=classes)
    order = np.argsort(-counts, kind="stable")
    means = np.stack(
        [given[found == number].mean(axis=0, dtype=np.float64) if counts[number] else given[0] for number in order]
    )
    return VisemeClasses(means.astype(np.float32), counts[order].astype(np.int64))
