"""Training of phone HMMs by maximum likelihood: monophones, then triphones whose states are tied by decision trees."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from visualspeech.errors import DataError
from visualspeech.jobs import log
from visualspeech.models.hmm.model import Hmm, HmmSettings
from visualspeech.models.hmm.questions import questions
from visualspeech.models.hmm.statistics import Gaussians, Statistics, accumulate
from visualspeech.models.hmm.tying import Cases, grow, monophones


def fit_monophones(
    training: Sequence[tuple], phones: Sequence[str], settings: HmmSettings | None = None, aam: str = ""
) -> Hmm:
    """HMMs of single phones: from evenly shared phones, by Baum-Welch with the alignment's phone boundaries.

    Parameters
    ----------
    training : utterances as (:class:`PhoneTrack`, appearance (T, N), its rate in Hz)
    phones : the inventory, K entries
    settings : states, rate, iterations
    aam : digest of the appearance model, kept with the HMMs

    Raises
    ------
    DataError
        There is no training utterance, or appearance that is no finite number.
    """
    settings = settings or HmmSettings()
    if not len(training):
        raise DataError("there is no training utterance to train HMMs on. Add recordings, or change `split`.")
    tying = monophones(len(phones), settings.states)
    stay = np.full((len(phones), settings.states), 0.5)
    first = accumulate(training, tying.find, tying.gaussians, None, stay, settings.rate, settings.step)
    everywhere, floor = _overall(first, settings)
    if not np.isfinite(everywhere.mean).all():
        raise DataError("a training utterance holds appearance that is no number; delete the features, run again.")
    start = first.gaussians(floor, everywhere.at(np.zeros(tying.gaussians, int)))
    gaussians, stay, history = baum_welch(
        training, tying.find, start, first.stay(), settings, "monophone", settings.monophone_iterations
    )
    return Hmm("monophone", settings, tuple(phones), tying, gaussians, stay, aam, {"history": history})


def fit_tied(monophone: Hmm, training: Sequence[tuple]) -> Hmm:
    """HMMs of triphones with tied states, from those of single phones.

    Every triphone of training gets Gaussians of its own, held to those of its phone; trees tie their statistics; the
    tied Gaussians are estimated anew. Triphones that training lacks find a leaf by their answers.

    Parameters
    ----------
    monophone : from :func:`fit_monophones` on the same utterances
    training : as there
    """
    settings, count = monophone.settings, len(monophone.phones)
    untied = _Untied(_triphones(training), count, settings.states)
    parent = monophone.tying.find(untied.triphones).ravel()
    prior = monophone.gaussians.at(parent)
    gaussians, stay, floor = prior, monophone.stay, None
    for _ in range(settings.untied_iterations):
        sums = accumulate(training, untied.find, len(parent), gaussians, stay, settings.rate, settings.step)
        floor = _overall(sums, settings)[1] if floor is None else floor
        gaussians, stay = sums.gaussians(floor, prior, settings.map_tau), sums.stay()
    log.info("%d triphones, %d Gaussians before tying", len(untied.triphones), len(parent))
    # Frames between those of the video say nothing new: a frame counts as the share of a frame of video that it is.
    weight = min(training[0][2] / settings.rate, 1.0)
    cases = Cases(
        np.repeat(untied.triphones, settings.states, axis=0),
        np.tile(np.arange(settings.states), len(untied.triphones)),
        *(weight * part for part in (sums.occupancy, sums.first, sums.second)),
    )
    tying = grow(
        cases,
        questions(monophone.phones),
        count,
        settings.states,
        floor,
        settings.min_frames,
        settings.mdl_factor,
        settings.tree_per_phone,
    )
    log.info("%d Gaussians after tying", tying.gaussians)
    start = _pooled(sums, tying.find(untied.triphones).ravel(), tying.gaussians).gaussians(
        floor, _overall(sums, settings)[0].at(np.zeros(tying.gaussians, int))
    )
    gaussians, stay, history = baum_welch(training, tying.find, start, stay, settings, "tied", settings.tied_iterations)
    about = {
        "triphones": len(untied.triphones),
        "gaussians": tying.gaussians,
        "history": [*monophone.about.get("history", []), *history],
    }
    return replace(monophone, kind="tied", tying=tying, gaussians=gaussians, stay=stay, about=about)


def baum_welch(
    training: Sequence[tuple],
    find: Callable,
    gaussians: Gaussians,
    stay: np.ndarray,
    settings: HmmSettings,
    stage: str,
    iterations: int,
) -> tuple[Gaussians, np.ndarray, list]:
    """Iterations of Baum-Welch: Gaussians, probabilities of staying, and (stage, iteration, figure, value) of each.

    The likelihood that an iteration reports is that of the model it began with.
    """
    history, floor = [], None
    for iteration in range(1, iterations + 1):
        sums = accumulate(training, find, len(gaussians.mean), gaussians, stay, settings.rate, settings.step)
        floor = _overall(sums, settings)[1] if floor is None else floor
        gaussians, stay = sums.gaussians(floor, gaussians), sums.stay()
        mean = sums.log_likelihood / sums.frames
        log.info("%s iteration %d of %d: log-likelihood %.4f a frame", stage, iteration, iterations, mean)
        history.append([stage, iteration, "log_likelihood", mean])
    return gaussians, stay, history


class _Untied:
    """A Gaussian for each state of each triphone that training has."""

    def __init__(self, triphones: np.ndarray, phones: int, states: int) -> None:
        self.triphones, self._size, self._states = triphones, (phones,) * 3, states
        self._codes = np.ravel_multi_index(triphones.T, self._size)

    def find(self, triphones: np.ndarray) -> np.ndarray:
        row = np.searchsorted(self._codes, np.ravel_multi_index(triphones.T, self._size))
        return row[:, None] * self._states + np.arange(self._states)


def _triphones(training: Sequence[tuple]) -> np.ndarray:
    """All triphones of the utterances, sorted."""
    found: set[tuple[int, ...]] = set()
    for number in range(len(training)):
        found.update(map(tuple, training[number][0].triphones.tolist()))
    return np.array(sorted(found))


def _overall(sums: Statistics, settings: HmmSettings) -> tuple[Gaussians, np.ndarray]:
    """One Gaussian of all frames, and the least variance of a state."""
    frames = sums.occupancy.sum()
    mean = sums.first.sum(axis=0) / frames
    variance = np.maximum(sums.second.sum(axis=0) / frames - mean**2, 1e-10)
    visits = sums.visits.sum()
    length = frames / visits
    spread = max(sums.stayed_squares.sum() / visits - length**2, 1e-2)
    overall = Gaussians(mean[None], variance[None], np.array([length]), np.array([spread]))
    return overall, settings.variance_floor * variance


def _pooled(sums: Statistics, to: np.ndarray, count: int) -> Statistics:
    """Statistics of Gaussians that are tied: number g goes to number to[g] of ``count``."""
    tied = {}
    for name in ("occupancy", "first", "second", "visits", "stayed", "stayed_squares"):
        values = getattr(sums, name)
        tied[name] = np.zeros((count, *values.shape[1:]))
        np.add.at(tied[name], to, values)
    return replace(sums, **tied)
