"""Significance of differences between rows: paired tests over test utterances with Holm's correction.

All pairs of rows are tested, not only pairs with the best row: the best row is chosen on the same utterances, and
Holm's correction does not hold for a family of tests that is chosen after looking at the data.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from visualspeech.evaluation.layout import Cell, Row, Table, interval
from visualspeech.evaluation.measured import MeasuredRows
from visualspeech.evaluation.metrics import METRICS, Metric, metric_named, statistics_of
from visualspeech.evaluation.statistics import BootstrapSettings, Sampled, draws, figure, sample
from visualspeech.fields import MAX_SEED, Settings, setting

TESTS = ("wilcoxon", "permutation")
COLUMNS = ("metric", "first", "second", "first_value", "second_value", "difference", "low", "high", "p", "p_holm",
           "better")  # fmt: skip


@dataclass(frozen=True)
class ComparisonSettings(Settings):
    """Paired tests over utterances between all pairs of rows, Holm-corrected.

    ``wilcoxon`` is the signed-rank test of the utterances' differences (Wilcoxon 1945). ``permutation`` tests the
    difference of the two corpus figures by random changes of the signs of the utterances' differences, or by all
    changes if there are at most ``permutations`` of them. The family of the correction is all pairs of one measure
    (Holm 1979).
    """

    section = "tables.comparison"
    test: str = setting(
        "wilcoxon",
        "Wilcoxon signed-rank test, or permutation test with random signs of the differences.",
        choices=TESTS,
    )
    level: float = setting(
        0.05, "Significance level of all pairs of one measure together, for example 0.05.", above=0, below=1
    )
    permutations: int = setting(
        10_000, "Number of random draws of the permutation test.", minimum=100, maximum=1_000_000
    )
    seed: int = setting(0, "Seed of the permutation test.", minimum=0, maximum=MAX_SEED)


def holm(p: np.ndarray) -> np.ndarray:
    """P values (n,) corrected by Holm's step-down method for a family of n; in the order given."""
    p = np.asarray(p, float)
    order = np.argsort(p, kind="stable")
    stepped = np.maximum.accumulate(p[order] * np.arange(len(p), 0, -1))
    corrected = np.empty_like(p)
    corrected[order] = np.minimum(stepped, 1.0)
    return corrected


def signed_rank(differences: np.ndarray) -> float:
    """P value of Wilcoxon's signed-rank test, two-sided, of paired differences (n,); 1 where all of them are 0."""
    from scipy.stats import wilcoxon

    differences = differences[np.isfinite(differences)]
    if not np.any(differences):
        return 1.0
    # Rounded, so that equal differences are ties; otherwise rounding errors would rank them.
    differences = np.round(differences / np.abs(differences).max(), 10)
    return float(wilcoxon(differences, zero_method="pratt").pvalue)


def sign_permutation(differences: np.ndarray, settings: ComparisonSettings) -> float:
    """P value, two-sided, of the sum of paired differences (n,) under changes of their signs."""
    from scipy.stats import permutation_test

    differences = differences[np.isfinite(differences)]
    if not np.any(differences):
        return 1.0
    return float(
        permutation_test(
            (differences,),
            lambda values, axis: np.sum(values, axis=axis),
            permutation_type="samples",
            vectorized=True,
            n_resamples=settings.permutations,
            rng=np.random.default_rng(settings.seed),
        ).pvalue
    )


def compare(
    measured: MeasuredRows,
    metrics: Sequence[str],
    settings: ComparisonSettings | None = None,
    bootstrap: BootstrapSettings | None = None,
):
    """Paired tests of all pairs of rows except the floor, one line per measure and pair.

    Parameters
    ----------
    measured : the rows; repetitions are pooled
    metrics : names of measures; the tests of one measure form a family
    settings : of the tests
    bootstrap : of the interval of each difference

    Returns
    -------
    DataFrame
        :data:`COLUMNS`. ``first`` is the row with the better corpus figure; ``difference`` is first minus second with
        its paired bootstrap interval; ``better`` names the first row where the corrected p value is below the level,
        and is empty elsewhere

    Raises
    ------
    DataError
        There is no test utterance.
    """
    import pandas

    settings, bootstrap = settings or ComparisonSettings(), bootstrap or BootstrapSettings()
    measured = measured.pooled()
    drawn = draws(measured.utterances, bootstrap)
    tables = {row.name: measured.tables[row.name] for row in measured.rows if row.role != "floor"}
    lines = []
    for metric in map(metric_named, metrics):
        statistics = {row: statistics_of(table, metric) for row, table in tables.items()}
        sampled = {row: sample(table, metric, drawn) for row, table in tables.items()}
        costs = {row: metric.cost(of_row.value) for row, of_row in sampled.items()}
        pairs = list(combinations(sorted(tables, key=costs.get), 2))
        p = np.array([paired_p(metric, statistics[first], statistics[second], settings) for first, second in pairs])
        for (first, second), own, corrected in zip(pairs, p, holm(p), strict=True):
            one, other = sampled[first], sampled[second]
            between = figure(Sampled(one.value - other.value, one.samples - other.samples), bootstrap.level)
            real = corrected < settings.level
            lines.append(
                (metric.name, first, second, one.value, other.value, between.value, between.low, between.high, own,
                 corrected, first if real else "")
            )  # fmt: skip
    return pandas.DataFrame(lines, columns=list(COLUMNS))


def paired_p(metric: Metric, first: np.ndarray, second: np.ndarray, settings: ComparisonSettings) -> float:
    """P value of the difference of two rows, each given by :func:`visualspeech.evaluation.metrics.statistics_of`."""
    if settings.test == "permutation" and metric.is_additive:
        # Both figures have the same denominator, so the sum of these differences is proportional to their difference.
        return sign_permutation(first[:, 0] - second[:, 0], settings)
    differences = metric.cost(metric.value(first)) - metric.cost(metric.value(second))
    return signed_rank(differences) if settings.test == "wilcoxon" else sign_permutation(differences, settings)


def comparison_tables(
    frame, measured: MeasuredRows, settings: ComparisonSettings, facts: Sequence[tuple[str, str]] = (), digits: int = 3
) -> tuple[Table, ...]:
    """One table per measure: rows in order of the figure, difference to the best row, significant differences.

    Parameters
    ----------
    frame : from :func:`compare`, with the rows and settings it was made with
    """
    tables, of_name = [], {row.name: row for row in measured.pooled().rows}
    for name in dict.fromkeys(frame["metric"]):
        part = frame[frame["metric"] == name]
        values = dict(zip(part["first"], part["first_value"], strict=True))
        values |= dict(zip(part["second"], part["second_value"], strict=True))
        best = part["first"].iloc[0]
        to_best = {row.second: row for row in part.itertuples() if row.first == best}
        rows = []
        for row in (best, *to_best):
            wins = int((part["better"] == row).sum())
            losses = int(((part["second"] == row) & (part["better"] != "")).sum())
            figure_shown = Cell(f"{values[row]:.{digits}f}", best=row == best)
            cells = (figure_shown, *_to_best(to_best.get(row), digits), Cell(str(wins)), Cell(str(losses)))
            rows.append(Row(of_name[row].title, cells, of_name[row].role))
        tables.append(
            Table(
                title=f"{METRICS[name].title}: paired comparisons",
                columns=(METRICS[name].heading, "best minus row", "p", "better than", "worse than"),
                rows=tuple(rows),
                facts=() if tables else tuple(facts),
                notes=() if tables else _notes(len(part), measured.utterances, settings),
            )
        )
    return tuple(tables)


def _to_best(line, digits: int) -> tuple[Cell, Cell]:
    if line is None:
        return Cell(""), Cell("")
    p = "< 0.0001" if line.p_holm < 1e-4 else f"{line.p_holm:.4f}"
    difference = Cell(f"{line.difference:.{digits}f}", interval(f"{line.low:.{digits}f}", f"{line.high:.{digits}f}"))
    return difference, Cell(p, best=bool(line.better))


def _notes(pairs: int, utterances: int, settings: ComparisonSettings) -> tuple[str, ...]:
    test = "Wilcoxon's signed-rank test" if settings.test == "wilcoxon" else "a permutation test"
    notes = [
        f"Paired over utterances by {test}, two-sided. P values are Holm-corrected for all {pairs} pairs of rows; "
        f"those below {settings.level:g} are bold. “Better than” and “worse than” count the rows from which a row "
        "differs significantly. Intervals are paired bootstrap intervals of the difference, uncorrected.",
        "The best value of each measure is bold.",
    ]
    smallest_p = 2.0 ** (1 - utterances)
    if smallest_p * pairs >= settings.level:
        notes.append(
            f"With {utterances} test utterances no p value can fall below {smallest_p:.2g}. After the correction for "
            f"{pairs} pairs this exceeds the significance level, so no difference can be significant here."
        )
    return tuple(notes)
