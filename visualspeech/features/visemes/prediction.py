"""Visemes of a text: predicted from phones and their times by a model that is learned from training utterances.

Two things are predicted at each frame by ridge regression on the phones about it (:mod:`.text_features`): the visual
parameters, and the share of training frames of such a context that each class of visemes has. The predicted parameters
are cut into gestures by the code that cuts recorded ones. The classes of the gestures are the most likely sequence
(Viterbi) under three scores: how near the predicted parameters are to the mean of a class, the predicted shares of the
classes, and how often a class follows another one in training.

What is predicted of a training utterance by a model that knows it would be nearer to the recording than what is
predicted of a new one, and a network that learns from it would trust it too much. Training utterances are therefore
cross-fitted: they are divided into folds, and the visemes of a fold are predicted by a model of the others. All models
come from one pass over the data, because ridge regression needs only sums, from which those of a fold are subtracted.
"""

import hashlib
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from visualspeech.errors import DataError
from visualspeech.features.visemes.classes import VisemeClasses
from visualspeech.features.visemes.regression import Sums
from visualspeech.features.visemes.segmentation import Gestures, resampled
from visualspeech.features.visemes.text_features import frame_codes, indicators, number_of_codes
from visualspeech.speech.alignment import Alignment

MAX_INDICATORS = 2048  # the most frequent ones; the work of a fit grows with the cube of their number
MIN_SECONDS = 0.1  # of training in which an indicator must be 1
PENALTY = 0.1  # seconds of training that the weight 0 counts for
# Weights of the scores of a sequence of classes, chosen on the validation utterances of GRID (benchmarks/visemes.py).
NEARNESS, FOLLOWING = 2.0, 0.2
MIN_ERROR = 1e-9  # see `TextModel.error`
_LEAST_SHARE = 1e-3  # of a class in a context; regression also gives negative ones
_FRAMES_AT_A_TIME = 10_000  # of a fold, that enter its sums together
_FOLLOWED = 0.05  # what is added to the count of each pair of classes


@dataclass(frozen=True)
class CrossFit:
    """Models for training utterances, each of which does not know the utterances of one of K folds.

    Parameters
    ----------
    training : (U,) int64 ascending, digests of the ids of the training utterances; the folds take turns
    weights : (K, F, D + N) float32, see :class:`TextModel`
    offsets : (K, D + N) float32
    """

    training: np.ndarray
    weights: np.ndarray
    offsets: np.ndarray

    def fold_of(self, utterance: str) -> int | None:
        """Number of the fold of an utterance; None for one that is not of the training."""
        return fold_of(utterance, self.training, len(self.weights))


@dataclass(frozen=True)
class TextModel:
    """A model of dynamic visemes given phones and their times.

    Parameters
    ----------
    known : (F,) int64 ascending, the indicators that it reads
    weights : (F, D + N) float32 of D parameters and N classes, from all training utterances
    offsets : (D + N,) float32
    follows : (N + 1, N) float32 log-probability that a class follows another one; in the last row, that it is the first
    error : mean square of the error of the D parameters together, of training utterances that a model does not know
    crossfit : the models for training utterances; None where they are not cross-fitted
    """

    known: np.ndarray
    weights: np.ndarray
    offsets: np.ndarray
    follows: np.ndarray
    error: float
    crossfit: CrossFit | None = None

    def predict(
        self, alignment: Alignment, frames: int, rate: float, phones: Sequence[str], utterance: str = ""
    ) -> tuple[np.ndarray, np.ndarray]:
        """Parameters (frames, D) and shares of the classes (frames, N), which can be negative.

        Parameters
        ----------
        phones : inventory
        utterance : id; that of a training utterance selects a model that does not know it
        """
        fold = None if self.crossfit is None else self.crossfit.fold_of(utterance)
        weights, offsets = (
            (self.weights, self.offsets) if fold is None else (self.crossfit.weights[fold], self.crossfit.offsets[fold])
        )
        rows = indicators(frame_codes(alignment, frames, rate, phones), self.known)
        values = rows @ weights.astype(np.float64) + offsets
        parameters, shares = np.split(values, [values.shape[1] - self.follows.shape[1]], axis=1)
        return parameters, shares

    def classes_of(
        self, classes: VisemeClasses, values: np.ndarray, shares: np.ndarray, gestures: Gestures
    ) -> np.ndarray:
        """The most likely classes (G,) of gestures, given what :meth:`predict` gives."""
        distances = classes.distances(resampled(values, gestures, classes.means.shape[1]))
        means = np.add.reduceat(shares, gestures.starts, axis=0) / gestures.lengths[:, None]
        scores = -NEARNESS * distances / self.error + np.log(np.maximum(means, _LEAST_SHARE))
        return best_path(scores, FOLLOWING * self.follows)


def fold_of(utterance: str, training: np.ndarray, folds: int) -> int | None:
    """Number of the fold of a training utterance, given the sorted digests of all; None for another utterance."""
    number = digest_of(utterance)
    place = int(np.searchsorted(training, number))
    return place % folds if place < len(training) and training[place] == number else None


def best_path(scores: np.ndarray, follows: np.ndarray) -> np.ndarray:
    """The sequence (G,) of states with the largest sum of scores (Viterbi).

    Parameters
    ----------
    scores : (G, N) of each state at each step
    follows : (N + 1, N) added where a state follows another one; in the last row, where it is the first
    """
    best, back = scores[0] + follows[-1], []
    for row in scores[1:]:
        reached = best[:, None] + follows[:-1]
        back.append(reached.argmax(axis=0))
        best = reached.max(axis=0) + row
    path = [int(best.argmax())]
    for before in reversed(back):
        path.append(int(before[path[-1]]))
    return np.array(path[::-1], np.int64)


@dataclass(frozen=True)
class Labelled:
    """A training utterance with its recorded visemes.

    Parameters
    ----------
    utterance : id
    alignment : phones with their times
    values : (T, D) recorded parameters
    rate : Hz
    gestures, classes : its gestures, and the class (G,) of each
    """

    utterance: str
    alignment: Alignment
    values: np.ndarray
    rate: float
    gestures: Gestures
    classes: np.ndarray


def fit_text_model(
    training: Callable[[], Iterable[Labelled]], phones: Sequence[str], classes: int, folds: int
) -> TextModel:
    """The models of all training utterances, and of all but each fold.

    Parameters
    ----------
    training : called for each of two passes over the training utterances
    phones : inventory
    classes : number N of classes
    folds : number of folds; with fewer training utterances, each is a fold; a single utterance is not cross-fitted

    Raises
    ------
    DataError
        There is no training utterance.
    """
    known, digests, follows = _first_pass(training(), phones, classes)
    if not len(digests):
        raise DataError("there is no training utterance to learn from. Add recordings, or change `split`.")
    folds = min(folds, len(digests))
    parts, penalty, size = _sums_of_folds(training(), phones, classes, known, digests, folds)
    whole = sum(parts[1:], parts[0])
    weights, offsets = whole.solve(penalty)
    # A single utterance cannot be left out.
    left_out = [(whole - part).solve(penalty) for part in parts] if folds > 1 else [(weights, offsets)]
    error = sum(part.errors(*one)[:size].sum() for part, one in zip(parts, left_out, strict=True)) / whole.frames
    of_folds = [np.array(part, np.float32) for part in zip(*left_out, strict=True)]
    return TextModel(
        known,
        weights.astype(np.float32),
        offsets.astype(np.float32),
        follows,
        # Parameters that are predicted without error leave no scale of distances; any positive one serves.
        float(max(error, MIN_ERROR)),
        CrossFit(digests, *of_folds) if folds > 1 else None,
    )


def _sums_of_folds(
    training: Iterable[Labelled],
    phones: Sequence[str],
    classes: int,
    known: np.ndarray,
    digests: np.ndarray,
    folds: int,
) -> tuple[list[Sums], float, int]:
    """The sums of each fold, the penalty in frames, and the number of parameters."""
    parts: list[Sums | None] = [None] * folds
    waiting: list[list] = [[] for _ in range(folds)]

    def entered(fold: int) -> Sums:
        codes, values = (np.concatenate(part) for part in zip(*waiting[fold], strict=True))
        waiting[fold] = []
        sums = Sums.of(codes, values, known)
        return sums if parts[fold] is None else parts[fold] + sums

    for one in training:
        fold = fold_of(one.utterance, digests, folds)
        codes = frame_codes(one.alignment, len(one.values), one.rate, phones)
        wanted = np.concatenate([one.values, np.eye(classes)[one.classes[one.gestures.of_frames()]]], axis=1)
        waiting[fold].append((codes, wanted))
        if sum(len(codes) for codes, _ in waiting[fold]) >= _FRAMES_AT_A_TIME:
            parts[fold] = entered(fold)
        penalty, size = PENALTY * one.rate, one.values.shape[1]
    return [entered(fold) if waiting[fold] else parts[fold] for fold in range(folds)], penalty, size


def _first_pass(
    training: Iterable[Labelled], phones: Sequence[str], classes: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The indicators that are read, the digests of the utterances, and the log-probabilities of pairs of classes."""
    seen, digests, least = np.zeros(number_of_codes(len(phones)), np.int64), [], 1.0
    pairs = np.full((classes + 1, classes), _FOLLOWED)
    for one in training:
        digests.append(digest_of(one.utterance))
        seen += np.bincount(frame_codes(one.alignment, len(one.values), one.rate, phones).ravel(), minlength=len(seen))
        np.add.at(pairs, (np.concatenate([[classes], one.classes[:-1]]), one.classes), 1)
        least = max(MIN_SECONDS * one.rate, 1.0)
    frequent = np.argsort(-seen, kind="stable")[:MAX_INDICATORS]
    known = np.sort(frequent[seen[frequent] >= least]) if seen.any() else frequent[:0]
    if not len(known):
        known = np.sort(frequent[:1])
    follows = np.log(pairs / pairs.sum(axis=1, keepdims=True))
    return known, np.unique(np.array(digests, np.int64)), follows.astype(np.float32)


def digest_of(utterance: str) -> int:
    """A number of 56 bits that stands for an utterance's id."""
    return int.from_bytes(hashlib.sha256(utterance.encode("utf-8")).digest()[:7], "big")
