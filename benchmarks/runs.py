"""What several benchmarks read of a finished run."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from visualspeech.evaluation.metrics import frame_correlation, frame_rmse


def alignment_files(corpus: Path) -> list[Path]:
    """The alignments of a corpus's folder, a file a shard."""
    return sorted(path for path in corpus.glob("alignment/*.tsv") if path.stem.isdigit())


def rmse_and_corr(pairs: Iterable[tuple[np.ndarray, np.ndarray]]) -> tuple[float, float]:
    """RMSE and CORR (Eq. 18 and 19) of (predicted, true) appearance (T, N), a pair an utterance."""
    frames = [(frame_rmse(*pair), np.nan_to_num(frame_correlation(*pair))) for pair in pairs]
    errors, correlations = (np.concatenate(parts) for parts in zip(*frames, strict=True))
    return float(errors.mean()), float(correlations.mean())
