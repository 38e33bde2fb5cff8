"""Significance of differences between rows: paired tests over test utterances with Holm's correction.

A row is better than another one only where the figure of the corpus and the test agree in direction: the test is of the
utterances, and the rank of a few of them can differ from their sum. All pairs of rows are tested, not only pairs with
the best row: the best row is chosen on the same utterances, and Holm's correction does not hold for a family of tests
that is chosen after looking at the data.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np

from visualspeech.evaluation.layout import Cell, Row, Table, interval
from visualspeech.evaluation.measured import MeasuredRows
from visualspeech.evaluation.metrics import METRICS, Metric, statistics_of
from visualspeech.evaluation.statistics import BootstrapSettings, Sampled, draws, figure, sample_row, selected
from visualspeech.fields import MAX_SEED, Settings, setting

TESTS = ("wilcoxon", "permutation")
COLUMNS = ("metric", "first", "second", "first_value", "second_value", "difference", "low", "high", "p", "p_holm",
           "better")  # fmt: skip


@dataclass(frozen=True)
class ComparisonSettings(Settings):
    """Paired tests over utterances between all pairs of rows, Holm-corrected.

    ``wilcoxon`` is the signed-rank test of the utterances' differences (Wilcoxon 1945). ``permutation`` tests the
    difference of the two corpus figures: each utterance is exchanged between the two rows or not, at random, or in all
    ways if there are at most ``permutations`` of them. Measures that are no sums over utterances (global-variance
    ratio, CCC) are always tested by permutation, because their figure in one utterance says little. The family of the
    correction is all pairs of one measure (Holm 1979).
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


class Tested(NamedTuple):
    """A two-sided paired test.

    Parameters
    ----------
    p : value
    direction : -1 where the first row has the lower costs by this test, 1 where it has the higher ones, else 0
    """

    p: float
    direction: int


def smallest_p(utterances: int) -> float:
    """The smallest p value that a paired test of so many utterances can have: all differences of one sign."""
    return 2.0 ** (1 - utterances)


def signed_rank(differences: np.ndarray) -> Tested:
    """Wilcoxon's signed-rank test of paired differences (n,); p is 1 where all of them are 0."""
    from scipy.stats import rankdata, wilcoxon

    differences = differences[np.isfinite(differences)]
    if not np.any(differences):
        return Tested(1.0, 0)
    # Rounded, so that equal differences are ties; otherwise rounding errors would rank them.
    differences = np.round(differences / np.abs(differences).max(), 10)
    ranks = np.sum(np.sign(differences) * rankdata(np.abs(differences)))
    return Tested(float(wilcoxon(differences, zero_method="pratt").pvalue), int(np.sign(ranks)))


def exchange_test(metric: Metric, first: np.ndarray, second: np.ndarray, settings: ComparisonSettings) -> Tested:
    """Permutation test of the difference of two corpus figures, under exchanges of utterances between the rows.

    Parameters
    ----------
    first, second : statistics of the utterances of two rows, (utterances, k) each
    """
    from scipy.stats import permutation_test

    both, count = np.concatenate([first, second]), len(first)

    def difference(one: np.ndarray, other: np.ndarray, axis: int) -> np.ndarray:
        chosen = (np.moveaxis(rows.astype(int), axis, -1) for rows in (one, other))
        figures = (metric.cost(metric.value(selected(both, rows))) for rows in chosen)
        return next(figures) - next(figures)

    rows = np.arange(count), np.arange(count, 2 * count)
    observed = float(difference(*rows, axis=0))
    if not np.isfinite(observed) or np.array_equal(first, second):
        return Tested(1.0, 0)
    if count < 2:  # of one utterance, an exchange says nothing
        return Tested(1.0, int(np.sign(observed)))
    found = permutation_test(
        rows,
        difference,
        permutation_type="samples",
        vectorized=True,
        batch=max(1, 1_000_000 // count),
        n_resamples=settings.permutations,
        rng=np.random.default_rng(settings.seed),
    )
    return Tested(float(found.pvalue), int(np.sign(observed)))


def paired_test(metric: Metric, first: np.ndarray, second: np.ndarray, settings: ComparisonSettings) -> Tested:
    """The test of two rows, each given by :func:`visualspeech.evaluation.metrics.statistics_of`."""
    if settings.test == "permutation" or not metric.is_additive:
        return exchange_test(metric, first, second, settings)
    return signed_rank(metric.cost(metric.value(first)) - metric.cost(metric.value(second)))


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
        its paired bootstrap interval; ``better`` names the first row where the corrected p value is below the level
        and the test finds the first row better too, and is empty elsewhere

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
    for metric in measured.metrics(metrics):
        statistics = {row: statistics_of(table, metric) for row, table in tables.items()}
        sampled = {row: sample_row(measured, row, metric, drawn, bootstrap) for row in tables}
        costs = {row: metric.cost(of_row.value) for row, of_row in sampled.items()}
        pairs = list(combinations(sorted(tables, key=costs.get), 2))
        tested = [paired_test(metric, statistics[first], statistics[second], settings) for first, second in pairs]
        p = np.array([one.p for one in tested])
        for (first, second), (own, direction), corrected in zip(pairs, tested, holm(p), strict=True):
            one, other = sampled[first], sampled[second]
            between = figure(Sampled(one.value - other.value, one.samples - other.samples), bootstrap.level)
            real = corrected < settings.level and direction < 0
            lines.append(
                (metric.name, first, second, one.value, other.value, between.value, between.low, between.high, own,
                 corrected, first if real else "")
            )  # fmt: skip
    return pandas.DataFrame(lines, columns=list(COLUMNS))


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
                title=f"{METRICS[name].title}, {METRICS[name].protocol}: paired comparisons",
                columns=(METRICS[name].heading, "best minus row", "p", "better than", "worse than"),
                rows=tuple(rows),
                facts=() if tables else tuple(facts),
                notes=() if tables else _notes(len(part), measured.utterances, settings),
                metrics=(name,) * 5,
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
    exchange = "a permutation test of the corpus figures, in which utterances are exchanged between the rows"
    test = f"Wilcoxon's signed-rank test, except for the global-variance ratio and CCC, which are tested by {exchange}"
    test = test if settings.test == "wilcoxon" else exchange
    notes = [
        f"Paired over utterances by {test}, two-sided. P values are Holm-corrected for all {pairs} pairs of rows; "
        f"those below {settings.level:g} are bold where test and figure agree in direction. “Better than” and “worse "
        "than” count the rows from which a row differs so. Intervals are paired bootstrap intervals of the difference, "
        "uncorrected.",
        "The best value of each measure is bold.",
    ]
    smallest = smallest_p(utterances)
    if smallest * pairs >= settings.level:
        notes.append(
            f"With {utterances} test utterances no p value can fall below {smallest:.2g}. After the correction for "
            f"{pairs} pairs this exceeds the significance level, so no difference can be significant here."
        )
    return tuple(notes)
