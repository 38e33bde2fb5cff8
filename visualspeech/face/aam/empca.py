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

LIMIT = 400
"""Maximum number of components for an energy target without a limit of its own."""

_SPARE = 10  # additional components during the iteration, because the last ones converge slowest
_SAMPLE = 1500  # rows whose exact components are the start of the iteration


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
    at_most: int | None = None,
    iterations: int = 10,
    seed: int = 0,
    tolerance: float = 1e-4,
    what: str = "rows",
) -> Components:
    """The leading principal components of many long rows.

    The iteration starts from the components of a random sample of rows, which saves most passes; what it converges to
    does not depend on the start.

    Parameters
    ----------
    rows : n rows of d values, read ``iterations`` + 3 times at most for each number of components tried
    components : how many, or None where ``energy`` is given
    energy : fraction of the total variance to hold, above 0 and below 1; components grow in blocks until it is reached,
        and the least number that reaches it is kept
    at_most : with ``energy``, keep no more components than this; the log says so when they hold less
    iterations : most passes of both steps; fewer when the variance held grows by less than ``tolerance`` of the total
        from one pass to the next
    seed : of the sample and of random components beyond it
    what : name of the rows in messages

    Raises
    ------
    DataError
        Fewer than two rows, all the same, or values that are not finite.
    SettingError
        More components are asked for than the data can have, or the energy is not reached with ``LIMIT`` components.
    """
    if (components is None) == (energy is None):
        raise SettingError(f"{what}: give either a number of components or an energy fraction.")
    count, dimension = rows.shape
    mean, total = moments(rows)
    possible = min(count - 1, dimension)
    if energy is None and not 0 < components <= possible:
        raise SettingError(
            f"{what}: {components} components asked for, but {count} rows of {dimension} values have at most "
            f"{possible}. Ask for fewer, give an energy fraction, or train on more images."
        )
    if total <= 1e-12 * max(float(np.square(mean).sum()), 1e-30):
        raise DataError(f"{what}: all {count} rows are the same, there is nothing to learn from them")
    generator = np.random.default_rng(seed)
    basis, held = _sample_components(rows, mean, generator)
    limit = min(possible, components or at_most or LIMIT)
    # Components of the sample explain more of the sample than of all data, so this guess is low; it grows if necessary.
    wanted = limit if energy is None else min(int(1.2 * (np.searchsorted(held, energy) + 1)), limit)
    while True:
        width = min(wanted + _SPARE, possible)
        fill = generator.standard_normal((dimension, max(width - basis.shape[1], 0)), dtype=np.float32)
        start = np.concatenate([basis[:, :width], fill], axis=1)
        basis = _iterate(rows, mean, start, iterations, tolerance * total)
        basis, eigenvalues = _rotate(rows, mean, basis)
        held = np.cumsum(eigenvalues)[:wanted] / total
        if energy is None or held[-1] >= energy:
            break
        if wanted >= limit:
            if at_most is None:
                raise SettingError(
                    f"{what}: an energy of {energy:g} is not reached with {wanted} components (they hold "
                    f"{held[-1]:.4f} of the variance). Ask for less energy, or for a number of components."
                )
            log.warning(
                "%s: the %d components allowed hold %.4f of the variance, not %g", what, wanted, held[-1], energy
            )
            break
        log.info("%s: %d components hold %.4f of the variance, %g asked", what, wanted, held[-1], energy)
        wanted = min(int(wanted * 1.4) + 1, limit)
    keep = wanted if energy is None else min(int(np.searchsorted(held, energy)) + 1, wanted)
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


def _sample_components(rows: Rows, mean: np.ndarray, generator) -> tuple[np.ndarray, np.ndarray]:
    """Exact components (d, m) of a random sample of rows, and the fraction of the sample's variance they hold (m,)."""
    count = rows.shape[0]
    drawn = np.sort(generator.choice(count, min(count, _SAMPLE), replace=False, shuffle=False))
    parts, start = [], 0
    for chunk in rows.chunks():
        parts.append(chunk[drawn[(drawn >= start) & (drawn < start + len(chunk))] - start] - mean)
        start += len(chunk)
    sample = np.concatenate(parts)
    values, vectors = np.linalg.eigh((sample @ sample.T).astype(np.float64))
    values = np.maximum(values[::-1], 0)
    real = values > 1e-6 * values[0]
    basis = sample.T @ (vectors[:, ::-1][:, real] / np.sqrt(values[real])).astype(np.float32)
    return basis, np.cumsum(values[real]) / values.sum()


def _iterate(rows: Rows, mean: np.ndarray, start: np.ndarray, iterations: int, min_gain: float) -> np.ndarray:
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
        # M step. The factor scatter^-1 does not change the spanned space, so it is omitted before orthonormalisation.
        basis = np.linalg.qr(products)[0]
        if held - before < min_gain:
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
    """Components with signs such that the largest value of each is positive; the sign of a component is arbitrary."""
    largest = components[np.arange(len(components)), np.abs(components).argmax(axis=1)]
    return components * np.where(largest < 0, -1, 1).astype(components.dtype)[:, None]


def pca(
    rows: np.ndarray,
    components: int | None = None,
    energy: float | None = None,
    at_most: int | None = None,
    what: str = "rows",
) -> Components:
    """Exact principal components of rows (n, d) that fit into memory and are not long; as :func:`em_pca` otherwise.

    Raises
    ------
    DataError
        Fewer than two rows, or no variance.
    SettingError
        More components asked for than the data has directions with variance.
    """
    if (components is None) == (energy is None):
        raise SettingError(f"{what}: give either a number of components or an energy fraction.")
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
    if energy is not None:
        components = min(int(np.searchsorted(np.cumsum(values) / total, energy) + 1), rank, at_most or rank)
    if not 0 < components <= rank:
        raise SettingError(
            f"{what}: {components} components asked for, but the training data varies in {rank} directions only. "
            "Ask for fewer, give an energy fraction, or train on more images."
        )
    kept = _signed(vectors[:components])
    return Components(mean.astype(np.float32), kept.astype(np.float32), values[:components], total)
