"""Maximum-likelihood training of phone HMMs: monophone HMMs, then HMMs of phones in context with tied states."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from visualspeech.errors import DataError
from visualspeech.jobs import log
from visualspeech.models.hmm.model import Hmm, HmmSettings
from visualspeech.models.hmm.questions import questions
from visualspeech.models.hmm.segments import ContextLayout, Example, layout_text
from visualspeech.models.hmm.statistics import Gaussians, Statistics, accumulate
from visualspeech.models.hmm.tying import Cases, grow, monophones


def fit_monophones(training: Sequence[Example], phones: Sequence[str], settings: HmmSettings | None = None) -> Hmm:
    """Monophone HMMs: a flat start inside the phone boundaries of the alignment, then Baum-Welch.

    Parameters
    ----------
    training : utterances as (:class:`PhoneTrack`, values (T, N), their rate in Hz)
    phones : inventory, K entries
    settings : states, rate, iterations

    Raises
    ------
    DataError
        There is no training utterance, the layouts of the phone contexts differ, the states cannot be shared out over
        the divisions of a phone, or a value is not finite.
    """
    settings = settings or HmmSettings()
    if not len(training):
        raise DataError("there is no training utterance to train HMMs on. Add recordings, or change `split`.")
    layout = _layout(training)
    if settings.states % layout.divisions:
        raise DataError(
            f"`states: {settings.states}` of the HMMs must be a multiple of {layout.divisions}, the number of acoustic "
            "states whose times the input block gives."
        )
    tying = monophones(len(phones), settings.states, layout)
    self_transition = np.full((len(phones) * layout.divisions, tying.unit_states), 0.5)
    first = accumulate(training, tying.find, tying.gaussians, None, self_transition, *_rates(settings))
    overall, floor = _overall(first, settings)
    if not np.isfinite(overall.mean).all():
        raise DataError(
            "a training utterance has values that are not finite numbers; delete the features and run again."
        )
    start = first.gaussians(floor, overall.at(np.zeros(tying.gaussians, int)))
    gaussians, self_transition, history = baum_welch(
        training, tying.find, start, first.self_transition(), settings, "monophone", settings.monophone_iterations
    )
    self_transition = self_transition.reshape(len(phones), settings.states)
    return Hmm(settings, tuple(phones), tying, gaussians, self_transition, {"history": history})


def fit_tied(monophone: Hmm, training: Sequence[Example]) -> Hmm:
    """Tied-state HMMs of phones in context, from monophone HMMs.

    Every context that occurs in training gets its own Gaussians, with those of its phone as prior; decision trees tie
    their statistics; the tied Gaussians are estimated again. Contexts that do not occur in training reach a leaf by
    their answers. With contexts of three columns these are tied-state triphone HMMs.

    Parameters
    ----------
    monophone : from :func:`fit_monophones` on the same utterances
    training : see there

    Raises
    ------
    DataError
        The layouts of the phone contexts differ among the utterances, or from those of the monophone HMMs.
    """
    settings, count = monophone.settings, len(monophone.phones)
    layout = _layout(training)
    if monophone.tying.layout != layout:
        raise DataError(
            f"the monophone HMMs were trained on phone contexts of {layout_text(monophone.tying.layout)}; those of the "
            f"utterances have {layout_text(layout)}. Train the monophone HMMs again."
        )
    each = monophone.tying.unit_states
    untied = _Untied(_contexts(training), each)
    parent = monophone.tying.find(untied.contexts).ravel()
    prior = monophone.gaussians.at(parent)
    gaussians, self_transition, floor = prior, monophone.self_transition.reshape(-1, each), None
    for remaining in reversed(range(settings.untied_iterations)):
        sums = accumulate(training, untied.find, len(parent), gaussians, self_transition, *_rates(settings))
        floor = _overall(sums, settings)[1] if floor is None else floor
        self_transition = sums.self_transition()
        if remaining:  # the trees grow on the statistics of the last iteration
            gaussians = sums.gaussians(floor, prior, settings.map_tau)
    log.info("%d phone contexts, %d Gaussians before tying", len(untied.contexts), len(parent))
    # Frames between those of the targets carry no information: each counts as the share of one of theirs that it is.
    weight = min(training[0][2] / settings.rate, 1.0)
    first = untied.contexts[:, -1] * each if layout.divisions > 1 else np.zeros(len(untied.contexts), int)
    cases = Cases(
        np.repeat(untied.contexts, each, axis=0),
        (first[:, None] + np.arange(each)).ravel(),
        *(weight * values for values in (sums.occupancy, sums.first, sums.second)),
    )
    tying = grow(
        cases,
        questions(monophone.phones, layout.columns, layout.centre, layout.factors),
        count,
        settings.states,
        layout.centre,
        floor,
        settings.min_frames,
        settings.mdl_factor,
        settings.tree_per_phone,
        layout.divisions,
        layout.factors,
    )
    log.info("%d Gaussians after tying", tying.gaussians)
    start = _pooled(sums, tying.find(untied.contexts).ravel(), tying.gaussians).gaussians(
        floor, _overall(sums, settings)[0].at(np.zeros(tying.gaussians, int))
    )
    gaussians, self_transition, history = baum_welch(
        training, tying.find, start, self_transition, settings, "tied", settings.tied_iterations
    )
    about = {
        "contexts": len(untied.contexts),
        "gaussians": tying.gaussians,
        "history": [*monophone.about.get("history", []), *history],
    }
    self_transition = self_transition.reshape(monophone.self_transition.shape)
    return replace(monophone, tying=tying, gaussians=gaussians, self_transition=self_transition, about=about)


def baum_welch(
    training: Sequence[Example],
    find: Callable[[np.ndarray], np.ndarray],
    gaussians: Gaussians,
    self_transition: np.ndarray,
    settings: HmmSettings,
    stage: str,
    iterations: int,
) -> tuple[Gaussians, np.ndarray, list]:
    """Iterations of Baum-Welch: Gaussians, self-transition probabilities, and rows (stage, iteration, figure, value).

    The log-likelihood that an iteration reports is that of the model before it.
    """
    history, floor = [], None
    for iteration in range(1, iterations + 1):
        sums = accumulate(training, find, len(gaussians.mean), gaussians, self_transition, *_rates(settings))
        floor = _overall(sums, settings)[1] if floor is None else floor
        gaussians, self_transition = sums.gaussians(floor, gaussians), sums.self_transition()
        mean = sums.log_likelihood / sums.frames
        log.info("%s iteration %d of %d: log-likelihood %.4f per frame", stage, iteration, iterations, mean)
        history.append([stage, iteration, "log_likelihood", mean])
    return gaussians, self_transition, history


def _rates(settings: HmmSettings) -> tuple[float, int, str]:
    """What :func:`accumulate` needs of the settings."""
    return settings.rate, settings.step, settings.durations


class _Untied:
    """One Gaussian for each state of each phone context, or division of one, that occurs in training.

    Parameters
    ----------
    contexts : (M, C), all different
    states : of each row
    """

    def __init__(self, contexts: np.ndarray, states: int) -> None:
        self.contexts, self._states = contexts, states
        # Rows are looked up as they are: numbering them as digits overflows for wide contexts.
        self._rows = {context: row for row, context in enumerate(map(tuple, contexts.tolist()))}

    def find(self, contexts: np.ndarray) -> np.ndarray:
        """Gaussians (P, states) of the states of rows (P, C)."""
        rows = np.array([self._rows[context] for context in map(tuple, contexts.tolist())])
        return rows[:, None] * self._states + np.arange(self._states)


def _layout(training: Sequence[Example]) -> ContextLayout:
    """Layout of the phone contexts of all utterances, see :attr:`PhoneTrack.layout`."""
    layouts = {training[number][0].layout for number in range(len(training))}
    if len(layouts) != 1:
        found = "; ".join(map(layout_text, sorted(layouts)))
        raise DataError(f"the training utterances differ in the layout of their phone contexts ({found}).")
    return layouts.pop()


def _contexts(training: Sequence[Example]) -> np.ndarray:
    """All phone contexts that occur in the utterances, (M, C), sorted."""
    return np.unique(np.concatenate([training[number][0].contexts for number in range(len(training))]), axis=0)


def _overall(sums: Statistics, settings: HmmSettings) -> tuple[Gaussians, np.ndarray]:
    """One Gaussian of all frames, and the minimum variance of a state (D,)."""
    frames = sums.occupancy.sum()
    mean = sums.first.sum(axis=0) / frames
    variance = np.maximum(sums.second.sum(axis=0) / frames - mean**2, 1e-10)
    visits = sums.visits.sum()
    length = frames / visits
    spread = max(sums.squared_durations.sum() / visits - length**2, 1e-2)
    overall = Gaussians(mean[None], variance[None], np.array([length]), np.array([spread]))
    return overall, settings.variance_floor * variance


def _pooled(sums: Statistics, to: np.ndarray, count: int) -> Statistics:
    """Statistics of ``count`` tied Gaussians: those of Gaussian g are added to tied Gaussian ``to[g]``."""
    tied = {}
    for name in ("occupancy", "first", "second", "visits", "durations", "squared_durations"):
        values = getattr(sums, name)
        tied[name] = np.zeros((count, *values.shape[1:]))
        np.add.at(tied[name], to, values)
    return replace(sums, **tied)
