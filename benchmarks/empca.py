"""EM-PCA beside a randomised SVD (Halko, Martinsson and Tropp 2011): energy held, seconds, memory.

Run: python -m benchmarks.empca [ROWS [VALUES [COMPONENTS]]]

ROWS rows (20000) of VALUES values (18000) are reduced to COMPONENTS components (100). The rows are like textures, with
a spectrum that falls slowly, and noise; they lie in a file, which EM-PCA reads in chunks. The randomised SVD (range
finder, four power iterations) needs all rows in memory, so memory is reported before it starts.
"""

import tempfile
import time

import numpy as np

from benchmarks.command import run_main
from benchmarks.memory import peak_megabytes
from visualspeech.face.aam.empca import em_pca
from visualspeech.face.aam.rows import RowFile


def made_rows(folder: str, count: int, dimension: int, seed: int = 1) -> RowFile:
    generator = np.random.default_rng(seed)
    axes = generator.standard_normal((200, dimension), dtype=np.float32)
    sizes = (20 / np.arange(1, 201) ** 0.7).astype(np.float32)
    rows = RowFile(folder, dimension)
    for start in range(0, count, 500):
        size = min(500, count - start)
        coordinates = generator.standard_normal((size, 200), dtype=np.float32) * sizes
        rows.append(120 + coordinates @ axes + 2 * generator.standard_normal((size, dimension), dtype=np.float32))
    return rows


def randomised_svd(rows: RowFile, components: int, powers: int = 4, spare: int = 10, seed: int = 0) -> np.ndarray:
    """Variances of the leading components."""
    data = np.concatenate(list(rows.chunks()))
    data -= data.mean(axis=0, dtype=np.float64).astype(np.float32)
    start = np.random.default_rng(seed).standard_normal((rows.dimension, components + spare), dtype=np.float32)
    basis = np.linalg.qr(data @ start)[0]
    for _ in range(powers):
        basis = np.linalg.qr(data @ np.linalg.qr(data.T @ basis)[0])[0]
    return np.linalg.svd(basis.T @ data, compute_uv=False)[:components] ** 2 / rows.count


def memory_gb() -> float:
    return peak_megabytes() * 2**20 / 1e9


def main(count: int = 20000, dimension: int = 18000, components: int = 100) -> None:
    with tempfile.TemporaryDirectory() as folder:
        rows = made_rows(folder, count, dimension)
        print(f"{count} x {dimension}, {components} components; memory before: {memory_gb():.2f} GB")
        begin = time.perf_counter()
        ours = em_pca(rows, components=components)
        print(f"EM-PCA          {time.perf_counter() - begin:6.1f} s, energy {ours.energy:.6f}, {memory_gb():.2f} GB")
        begin = time.perf_counter()
        variances = randomised_svd(rows, components)
        energy = variances.sum() / ours.total_variance
        print(f"randomised SVD  {time.perf_counter() - begin:6.1f} s, energy {energy:.6f}, {memory_gb():.2f} GB")
        print(f"ratio of the energies, ours to theirs: {ours.energy / energy:.6f}")
        worst = np.abs(ours.components @ ours.components.T - np.eye(components)).max()
        print(f"largest departure from orthonormal components: {worst:.1e}")


if __name__ == "__main__":
    run_main(main, __doc__)
