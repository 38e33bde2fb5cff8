"""What a run found about a system, in one sentence: its best model against the training mean and a reference model.

The model is chosen on the validation utterances and measured on the test utterances, with the lip distance that all
systems share (:mod:`visualspeech.evaluation.lip_metrics`). It is called better than another one only where its figure
and a paired test over utterances agree.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from visualspeech.evaluation.comparisons import ComparisonSettings, holm, paired_test, smallest_p
from visualspeech.evaluation.gains import ranked_cells
from visualspeech.evaluation.layout import shown
from visualspeech.evaluation.lip_metrics import ACROSS
from visualspeech.evaluation.measured import BASE_FAMILY, MeasuredRows
from visualspeech.evaluation.metrics import METRICS, Metric, corpus_figure, is_measured, statistics_of
from visualspeech.evaluation.statistics import BootstrapSettings, Figure, draws, figure, sample_row
from visualspeech.models.rows import ModelRow

#: Measures by which a model is chosen; the first one that the statistics of the validation utterances hold.
CHOICE = ("rmse_appearance", "ccc_lower", "gv_ratio")
HMM = "hmm"
MEASURE = "lip_distance"
BETTER, WORSE, UNDECIDED = "better", "worse", "undecided"


@dataclass(frozen=True)
class Choice:
    """The rows of a system that its conclusion is about, by the names of pooled rows; empty for none.

    Parameters
    ----------
    ranked : its models, from the best to the worst on the validation utterances
    metric : by which they are ranked
    reference : the best model of the other sort: the best HMM, or the best network if an HMM is the best model
    baseline : the training mean
    """

    ranked: tuple[str, ...]
    metric: Metric
    reference: str = ""
    baseline: str = ""

    @property
    def best(self) -> str:
        """The best model on the validation utterances."""
        return self.ranked[0]


@dataclass(frozen=True)
class Versus:
    """The best model against another row on the test utterances.

    Parameters
    ----------
    row : name of the other row
    own : its figure
    p : value of the paired test, Holm-corrected for all comparisons of the conclusion
    verdict : whether the best model is ``better`` or ``worse``; ``undecided`` where figure and test do not agree
    """

    row: str
    own: Figure
    p: float
    verdict: str


@dataclass(frozen=True)
class Conclusion:
    """What was found about a system.

    Parameters
    ----------
    choice : the rows that it is about; None where no model can be ranked
    best : figure of the best model on the test utterances
    versus : the best model against the training mean and the reference
    text : the sentence
    """

    choice: Choice | None
    text: str
    best: Figure | None = None
    versus: tuple[Versus, ...] = ()


def choose(rows: Sequence[ModelRow], validation: Mapping[str, object]) -> Choice | None:
    """The best model of a system, and what it is compared with; None where no model has a figure.

    Parameters
    ----------
    rows : all rows of the system
    validation : name of a row with the role ``model`` -> statistics of the validation utterances
    """
    models = [row for row in rows if row.role == "model" and row.name in validation]
    metric = next((METRICS[name] for name in CHOICE if all(is_measured(validation[row.name], METRICS[name])
                                                           for row in models)), None)  # fmt: skip
    if not models or metric is None:
        return None
    defined = [row for row in models if np.isfinite(corpus_figure(validation[row.name], metric.name))]
    ranked = ranked_cells(defined, validation, metric)
    if not ranked:
        return None
    hmms = {row.cell or row.name for row in models if row.family == HMM}
    other = (cell for cell in ranked if (cell in hmms) != (ranked[0] in hmms))
    trivial = (row.cell or row.name for row in rows if row.family == BASE_FAMILY)
    reference = next(other, "") if hmms else ""
    return Choice(tuple(ranked), metric, reference, next(trivial, ""))


def conclude(
    rows: Sequence[ModelRow],
    validation: Mapping[str, object],
    lips: MeasuredRows,
    settings: ComparisonSettings,
    bootstrap: BootstrapSettings,
) -> Conclusion:
    """The conclusion about a system.

    Parameters
    ----------
    rows, validation : as of :func:`choose`
    lips : the rows with the lip statistics of the test utterances
    settings, bootstrap : of the tests and the intervals
    """
    choice, pooled, metric = choose(rows, validation), lips.pooled(), ACROSS[MEASURE]
    if choice is None:
        return Conclusion(None, "No model can be chosen: none has a figure on the validation utterances.")
    titles = pooled.titles
    count = f"of {len(choice.ranked)} models" if len(choice.ranked) > 1 else "the only model"
    measure = f"{'lowest' if choice.metric.best == 'low' else 'best'} {choice.metric.title}"
    opening = f"{titles[choice.best]} is the best {count} on the validation utterances ({measure})."
    if len(choice.ranked) == 1:
        opening = f"{titles[choice.best]} is {count}."
    if not is_measured(pooled.tables[choice.best], metric) or not pooled.utterances:
        return Conclusion(choice, f"{opening} Its lips cannot be compared with the recorded ones.")
    drawn = draws(pooled.utterances, bootstrap)
    names = [choice.best, *filter(None, (choice.baseline, choice.reference))]
    sampled = {name: sample_row(pooled, name, metric, drawn, bootstrap) for name in names}
    figures = {name: figure(one, bootstrap.level) for name, one in sampled.items()}
    costs = {name: statistics_of(pooled.tables[name], metric) for name in names}
    tested = [paired_test(metric, costs[choice.best], costs[name], settings) for name in names[1:]]
    versus = tuple(
        Versus(name, figures[name], float(p), _verdict(p, direction, figures[choice.best], figures[name], settings))
        for name, p, (_, direction) in zip(names[1:], holm([one.p for one in tested]), tested, strict=True)
    )
    own = figures[choice.best]
    text = (
        f"{opening} On the {pooled.utterances} test utterances its lips are on average {shown(own.value, 2)} % "
        f"[{shown(own.low, 2)}, {shown(own.high, 2)}] of the distance between the outer eye corners away from the "
        f"recorded ones"
    )
    if not versus:
        return Conclusion(choice, f"{text}.", own)
    text = f"{text}: {' and '.join(_clause(one, titles) for one in versus)}."
    if smallest_p(pooled.utterances) * len(versus) >= settings.level:
        text += f" With {pooled.utterances} utterances no difference can be significant."
    return Conclusion(choice, text, own, versus)


def _verdict(p: float, direction: int, best: Figure, other: Figure, settings: ComparisonSettings) -> str:
    """Whether the best model is better than another row, by its figure and the test together."""
    sign = int(np.sign(best.value - other.value))
    if not p < settings.level or sign != direction or not sign:
        return UNDECIDED
    return BETTER if sign < 0 else WORSE


def _clause(one: Versus, titles: Mapping[str, str]) -> str:
    relation = {BETTER: "better than", WORSE: "worse than", UNDECIDED: "not significantly different from"}[one.verdict]
    p = "p < 0.001" if one.p < 0.001 else f"p = {one.p:.3f}"
    title = titles[one.row]
    article = "the " if " " in title else ""  # "the MGE-trained HMM", but "FBB-128"
    return f"{relation} {article}{title} ({shown(one.own.value, 2)} %, {p})"
