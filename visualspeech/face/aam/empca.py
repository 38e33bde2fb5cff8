"""Principal components of rows that do not fit into memory, by expectation maximisation (Roweis 1998).

Roweis' two steps for rows Y (n, d), already centred, and components C (k, d)::

    E step   W = Y C' (C C')^-1          coordinates of the rows
    M step   C = (W' W)^-1 W' Y          components that best explain them

Each pass over the data does both, a chunk at a time, and needs memory for two (d, k) matrices only. The components are
orthonormalised between passes, which changes nothing of the space they span and makes C C' the identity. After the last
pass they are turned to the axes of the variance in that space (Rayleigh-Ritz), so that what comes out is PCA proper:
orthonormal, ordered, uncorrelated. The total variance is computed from the data, so that an energy fraction is one of
everything and not of what was kept.
"""

from typing import NamedTuple, Protocol

import numpy as np

from visualspeech.errors import DataError, SettingError
from visualspeech.jobs import log

_SPARE = 10  # more components than asked while iterating: the last ones asked for converge slowest
_FIRST_BLOCK = 40  # components tried first for an energy target


class Rows(Protocol):
    """A source of rows: its shape (n, d), and the rows in chunks (m, d) of float32, always in the same order."""

    shape: tuple[int, int]

    def chunks(self, size: int = 512): ...


class Components(NamedTuple):
    """The result of a principal component analysis.

    mean (d,) float32; components (k, d) float32, orthonormal rows; eigenvalues (k,) float64, variances along them,
    descending; total_variance float, of all d directions.
    """

    mean: np.ndarray
    components: np.ndarray
    eigenvalues: np.ndarray
    total_variance: float

    @property
    def energy(self) -> float:
        """Fraction of the total variance that the components hold."""
        return float(self.eigenvalues.sum() / self.total_variance) if self.total_variance > 0 else 1.0


def em_pca(
    rows: Rows,
    components: int | None = None,
    energy: float | None = None,
    iterations: int = 10,
    seed: int = 0,
    tolerance: float = 1e-4,
    most: int = 400,
    what: str = "rows",
) -> Components:
    """The leading principal components of many long rows.

    Parameters
    ----------
    rows : n rows of d values, read ``iterations`` + 2 times or a little more often
    components : how many, or None where ``energy`` is given
    energy : fraction of the total variance to hold, above 0 and below 1; components grow in blocks until it is reached,
        and the least number that reaches it is kept
    iterations : most passes of both steps (for each block); fewer when the variance held grows by less than
        ``tolerance`` of the total from one pass to the next
    most : most components that an energy target may take
    what : name of the rows in messages

    Raises
    ------
    DataError
        Fewer than two rows, or values that are not finite.
    SettingError
        More components asked for than the data can have, or the energy is not reached with ``most`` components.
    """
    if (components is None) == (energy is None):
        raise SettingError(f"{what}: give either a number of components or an energy fraction, and not both.")
    count, dimension = rows.shape
    mean, total = moments(rows)
    possible = min(count - 1, dimension)
    if components is not None and not 0 < components <= possible:
        raise SettingError(
            f"{what}: {components} components asked for, but {count} rows of {dimension} values have at most "
            f"{possible}. Ask for fewer, give an energy fraction, or train on more images."
        )
    if total <= 1e-12 * max(float(np.square(mean).sum()), 1e-30):
        raise DataError(f"{what}: all {count} rows are the same, there is nothing to learn from them")
    generator = np.random.default_rng(seed)
    wanted = min(components or _FIRST_BLOCK, possible)
    basis = np.empty((dimension, 0), np.float32)
    while True:
        width = min(wanted + _SPARE, possible)
        new = generator.standard_normal((dimension, width - basis.shape[1]), dtype=np.float32)
        basis = _iterate(rows, mean, np.concatenate([basis, new], axis=1), iterations, tolerance * total)
        basis, eigenvalues = _rotate(rows, mean, basis)
        if components is not None:
            keep = components
            break
        held = np.cumsum(eigenvalues)[:wanted] / total
        if held[-1] >= energy:
            keep = int(np.searchsorted(held, energy) + 1)
            break
        if wanted >= min(possible, most):
            raise SettingError(
                f"{what}: an energy of {energy:g} is not reached with {wanted} components (they hold {held[-1]:.4f} of "
                f"the variance). Ask for an energy below {held[-1]:.2f}, or train on more images."
            )
        log.info("%s: %d components hold %.4f of the variance, %g asked", what, wanted, held[-1], energy)
        wanted = min(int(wanted * 1.6), possible, most)
    return Components(mean, np.ascontiguousarray(_signed(basis[:, :keep].T)), eigenvalues[:keep], total)


def moments(rows: Rows) -> tuple[np.ndarray, float]:
    """Mean (d,) float32 and total variance (mean square distance from the mean) of rows, in one pass.

    Chunks are merged by the update of Chan, Golub and LeVeque (1983), which does not cancel for values far from zero.

    Raises
    ------
    DataError
        Fewer than two rows, or values that are not finite.
    """
    count, mean, scatter = 0, np.zeros(rows.shape[1]), 0.0
    for chunk in rows.chunks():
        chunk_mean = chunk.mean(axis=0, dtype=np.float64)
        away = chunk - chunk_mean.astype(np.float32)
        difference = chunk_mean - mean
        merged = count + len(chunk)
        scatter += float(np.einsum("ij,ij->i", away, away).sum(dtype=np.float64))
        scatter += float(difference @ difference) * count * len(chunk) / merged
        mean += difference * (len(chunk) / merged)
        count = merged
    if count < 2:
        raise DataError(f"principal components need two rows or more, got {count}")
    if not np.isfinite(scatter):
        raise DataError("values that are not finite among the rows")
    return mean.astype(np.float32), scatter / count


def _iterate(rows: Rows, mean: np.ndarray, start: np.ndarray, iterations: int, least_gain: float) -> np.ndarray:
    basis = np.linalg.qr(start)[0]
    before = 0.0
    for _ in range(iterations):
        products, scatter = np.zeros(basis.shape, np.float32), np.zeros((basis.shape[1],) * 2)
        for chunk in rows.chunks():
            centred = chunk - mean
            coordinates = centred @ basis  # E step
            products += centred.T @ coordinates
            scatter += coordinates.T @ coordinates
        held = float(np.trace(scatter)) / rows.shape[0]
        # M step. Its factor scatter^-1 does not change the space spanned; after orthonormalising it is needless.
        basis = np.linalg.qr(products)[0]
        if held - before < least_gain:
            break
        before = held
    return basis


def _rotate(rows: Rows, mean: np.ndarray, basis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    scatter = np.zeros((basis.shape[1],) * 2)
    for chunk in rows.chunks():
        coordinates = ((chunk - mean) @ basis).astype(np.float64)
        scatter += coordinates.T @ coordinates
    values, turn = np.linalg.eigh(scatter / rows.shape[0])
    return (basis.astype(np.float64) @ turn[:, ::-1]).astype(np.float32), np.maximum(values[::-1], 0)


def _signed(components: np.ndarray) -> np.ndarray:
    """Components whose largest value is positive: the sign of a component is free, so it is fixed."""
    largest = components[np.arange(len(components)), np.abs(components).argmax(axis=1)]
    return components * np.where(largest < 0, -1, 1).astype(components.dtype)[:, None]


def pca(rows: np.ndarray, components: int | None = None, energy: float | None = None, what: str = "rows") -> Components:
    """Exact principal components of rows (n, d) that fit into memory and are not long; as :func:`em_pca` otherwise.

    Raises
    ------
    DataError
        Fewer than two rows, or no variance.
    SettingError
        More components asked for than the data has directions with variance.
    """
    if (components is None) == (energy is None):
        raise SettingError(f"{what}: give either a number of components or an energy fraction, and not both.")
    if len(rows) < 2:
        raise DataError(f"principal components need two rows or more, got {len(rows)}")
    mean = rows.mean(axis=0, dtype=np.float64)
    centred = rows - mean
    values, vectors = np.linalg.eigh(centred.T @ centred / len(rows))
    values, vectors = np.maximum(values[::-1], 0), vectors[:, ::-1].T
    total = float(values.sum())
    if not total > 0:
        raise DataError(f"{what}: all {len(rows)} rows are the same, there is nothing to learn from them")
    rank = int(np.count_nonzero(values > 1e-10 * values[0]))
    if components is None:
        components = min(int(np.searchsorted(np.cumsum(values) / total, energy) + 1), rank)
    if not 0 < components <= rank:
        raise SettingError(
            f"{what}: {components} components asked for, but the training data varies in {rank} directions only. "
            "Ask for fewer, give an energy fraction, or train on more images."
        )
    kept = _signed(vectors[:components])
    return Components(mean.astype(np.float32), kept.astype(np.float32), values[:components], total)
