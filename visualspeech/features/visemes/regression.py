"""Ridge regression on sparse indicators, from sums over utterances, so that any of them can be left out afterwards."""

from dataclasses import dataclass

import numpy as np

from visualspeech.features.visemes.text_features import indicators


@dataclass(frozen=True)
class Sums:
    """Sums over T frames of indicators x (F,) and of what is predicted from them, y (M,).

    Parameters
    ----------
    gram : (F, F) of x x'
    cross : (F, M) of x y'
    ones : (F,) of x
    totals : (M,) of y
    squares : (M,) of y squared
    frames : T
    """

    gram: np.ndarray
    cross: np.ndarray
    ones: np.ndarray
    totals: np.ndarray
    squares: np.ndarray
    frames: int

    def __add__(self, other: "Sums") -> "Sums":
        return Sums(*(one + two for one, two in zip(vars(self).values(), vars(other).values(), strict=True)))

    def __sub__(self, other: "Sums") -> "Sums":
        return Sums(*(one - two for one, two in zip(vars(self).values(), vars(other).values(), strict=True)))

    @classmethod
    def of(cls, codes: np.ndarray, values: np.ndarray, known: np.ndarray) -> "Sums":
        """The sums of one utterance.

        Parameters
        ----------
        codes : (T, C) indicators that are 1 at each frame
        values : (T, M) what is predicted
        known : (F,) the indicators that count, ascending
        """
        rows, values = indicators(codes, known), np.asarray(values, np.float64)
        return cls(
            (rows.T @ rows).toarray(),
            rows.T @ values,
            np.asarray(rows.sum(axis=0)).ravel(),
            values.sum(axis=0),
            np.square(values).sum(axis=0),
            len(values),
        )

    def solve(self, penalty: float) -> tuple[np.ndarray, np.ndarray]:
        """Weights (F, M) and offsets (M,): y is predicted by offset + x' weights, the offset being the mean of y.

        Parameters
        ----------
        penalty : frames that the weight 0 counts for, positive
        """
        from scipy.linalg import cho_factor, cho_solve

        offset = self.totals / self.frames
        gram = self.gram + penalty * np.eye(len(self.gram))
        factor = cho_factor(gram, overwrite_a=True, check_finite=False)
        return cho_solve(factor, self.cross - np.outer(self.ones, offset), check_finite=False), offset

    def errors(self, weights: np.ndarray, offset: np.ndarray) -> np.ndarray:
        """Squared errors (M,) of a prediction, summed over the frames of these sums."""
        # Of y - offset - x'W: its three squares and products, from the sums alone.
        centred = self.squares - 2 * offset * self.totals + self.frames * offset**2
        crossed = self.cross - np.outer(self.ones, offset)
        return centred - 2 * (weights * crossed).sum(axis=0) + (weights * (self.gram @ weights)).sum(axis=0)
