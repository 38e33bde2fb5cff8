"""Utterances brought to a network: what is learned from them beforehand, and padded batches."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch

from visualspeech.errors import DataError
from visualspeech.models.network import check_labels


@dataclass(frozen=True)
class Content:
    """What one pass over utterances tells.

    Parameters
    ----------
    lengths : (M,) frames of each utterance
    mean : (N,) mean appearance of all frames
    deviation : one standard deviation for all dimensions: root of the mean of their variances (1 where nothing varies)
    digest : of labels and appearance, bit by bit
    """

    lengths: np.ndarray
    mean: np.ndarray
    deviation: float
    digest: str


def content(examples: Sequence, phones: int, name: str, parts: Sequence[int] = ()) -> Content:
    """One pass over utterances of (labels (T, 4), appearance (T, N)); ``name`` (training, validation) is for errors.

    ``parts`` are the numbers of values of what labels say beyond their four indices.

    Raises
    ------
    DataError
        There is no utterance, labels are outside the inventory of ``phones`` phones, or a value is no finite number.
    """
    if not len(examples):
        raise DataError(f"there is no {name} utterance to learn from. Add recordings, or change `split`.")
    lengths, total, squares, sha = [], 0.0, 0.0, hashlib.sha256()
    for labels, values in (examples[number] for number in range(len(examples))):
        check_labels(labels, phones, parts)
        if not np.isfinite(values).all():
            raise DataError(f"a {name} utterance holds appearance that is no number; delete the features, run again.")
        lengths.append(len(values))
        total = total + values.sum(axis=0, dtype=np.float64)
        squares = squares + np.square(values, dtype=np.float64).sum(axis=0)
        sha.update(f"{len(values)};".encode())
        sha.update(np.ascontiguousarray(labels, "<i2").tobytes())
        sha.update(np.ascontiguousarray(values, "<f4").tobytes())
    mean = total / sum(lengths)
    variance = np.maximum(squares / sum(lengths) - mean**2, 0).mean()
    return Content(np.array(lengths), mean, float(np.sqrt(variance)) or 1.0, sha.hexdigest())


def batches(lengths: np.ndarray, size: int, order: np.ndarray) -> list[np.ndarray]:
    """Utterances of similar length together, to pad little: within runs of 16 batches of the given order."""
    result = []
    for start in range(0, len(order), 16 * size):
        run = order[start : start + 16 * size]
        run = run[np.argsort(-lengths[run], kind="stable")]
        result += [run[first : first + size] for first in range(0, len(run), size)]
    return result


def batch(examples: Sequence, numbers: np.ndarray, mean: np.ndarray, scale: float):
    """Labels (N, T, 4 or more), lengths (N,) descending, targets (N, T, outputs); zero beyond an utterance's end."""
    pairs = [examples[int(number)] for number in numbers]
    lengths = torch.tensor([len(values) for _, values in pairs])
    labels = torch.zeros(len(pairs), int(lengths[0]), pairs[0][0].shape[1], dtype=torch.int64)
    targets = torch.zeros(len(pairs), int(lengths[0]), len(mean))
    for row, (indices, values) in enumerate(pairs):
        labels[row, : len(values)] = torch.tensor(np.asarray(indices, np.int64))
        targets[row, : len(values)] = torch.tensor(((values - mean) / scale).astype(np.float32))
    return labels, lengths, targets
