"""The one definition of a result table; :mod:`visualspeech.evaluation.table_formats` writes it in four forms.

A :class:`ResultTable` holds the figures already rounded to the digits that are shown, so that the forms cannot disagree
and a TSV read back gives the same Markdown, LaTeX and HTML.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from visualspeech.evaluation.metrics import METRICS, Metric, metric_named
from visualspeech.evaluation.statistics import BASE_ROW, BootstrapSettings, summarise
from visualspeech.fields import Settings, setting

ROW_TITLES = {
    "hmm_monophone": "HMM of phones",
    "hmm_tied": "HMM of tied triphones",
    "hmm_mge": "HMM after minimum generation error",
    "training_mean": "Training mean",
    "phone_state_mean": "Mean per phone state",
    "triphone_state_mean": "Mean per triphone state",
    "aam_reconstruction": "AAM reconstruction (floor)",
}
FLOOR_ROW = "aam_reconstruction"
PARTS = ("value", "low", "high", "ratio", "ratio_low", "ratio_high")


@dataclass(frozen=True)
class TableSettings(Settings):
    """What the result tables show."""

    section = "tables"
    metrics: tuple[str, ...] = setting(
        tuple(METRICS),
        "Measures shown, in the order of the columns.",
        item={"description": "A measure; its formula is in docs/papers.md.", "choices": METRICS},
        min_items=1,
        unique=True,
    )
    digits: int = setting(3, "Number of decimals of the measures.", minimum=0, maximum=12)
    ratio_digits: int = setting(3, "Number of decimals of the ratios to the training mean.", minimum=0, maximum=12)

    def digits_of(self, part: str) -> int:
        """Number of decimals of a figure, an interval or a ratio (a part of :data:`PARTS`)."""
        return self.ratio_digits if part.startswith("ratio") else self.digits


@dataclass(frozen=True)
class TableFacts:
    """What a table was computed on, printed with it.

    Parameters
    ----------
    corpus, experiment : names
    split_hash : from :func:`visualspeech.provenance.split_hash`
    drift : the method that removed slow drift between recordings (``none`` where it was not)
    """

    corpus: str
    experiment: str
    split_hash: str
    drift: str


@dataclass(frozen=True)
class ResultTable:
    """Figures of all rows, rounded as shown.

    Parameters
    ----------
    facts : (name, text) pairs printed above the table
    metrics : columns
    rows : names of rows, in order
    cells : (row, metric) -> part of :data:`PARTS` -> figure as text, empty where undefined
    best : the (row, metric) pairs that are best among the rows that predict (ties on the shown digits all count)
    """

    facts: tuple[tuple[str, str], ...]
    metrics: tuple[Metric, ...]
    rows: tuple[str, ...]
    cells: Mapping[tuple[str, str], Mapping[str, str]]
    best: frozenset[tuple[str, str]] = field(default=frozenset())


def run_facts(facts: TableFacts, table) -> tuple[tuple[str, str], ...]:
    """What the figures of a run were computed on, as facts of its sheets; ``table`` is of any of its rows."""
    return (
        ("corpus", facts.corpus),
        ("experiment", facts.experiment),
        ("split", facts.split_hash),
        ("drift removal", facts.drift),
        ("test utterances", str(len(table))),
        ("test frames", str(int(table["frames"].sum()))),
    )


def result_table(
    tables: Mapping[str, object],
    facts: TableFacts,
    settings: TableSettings | None = None,
    bootstrap: BootstrapSettings | None = None,
) -> ResultTable:
    """The result table of all rows.

    Parameters
    ----------
    tables : row name (networks as ``FBB-128``, baselines as in :data:`ROW_TITLES`) -> per-utterance table of the test
        utterances; networks come first in the order given, then the baselines in their fixed order
    facts : what the figures were computed on
    settings, bootstrap : what is shown, and how the intervals are drawn

    Raises
    ------
    SettingError
        A metric is unknown.
    DataError
        The training mean's row is missing, or rows were evaluated on different utterances.
    """
    settings, bootstrap = settings or TableSettings(), bootstrap or BootstrapSettings()
    rows = [row for row in tables if row not in ROW_TITLES] + [row for row in ROW_TITLES if row in tables]
    summary = summarise({row: tables[row] for row in rows}, settings.metrics, bootstrap)
    cells = {
        (line.row, line.metric): {part: _shown(getattr(line, part), settings.digits_of(part)) for part in PARTS}
        for line in summary.itertuples()
    }
    lines = [
        *run_facts(facts, tables[BASE_ROW]),
        (
            "intervals",
            f"{bootstrap.level * 100:g} % percentile bootstrap over utterances, {bootstrap.samples} samples, "
            f"seed {bootstrap.seed}",
        ),
    ]
    undefined = {row: int(tables[row]["corr_undefined"].sum()) for row in rows}
    if "corr" in settings.metrics and any(undefined.values()):
        counts = ", ".join(f"{row} {count}" for row, count in undefined.items() if count)
        lines.append(("frames with undefined correlation, counted as 0", counts))
    metrics = tuple(metric_named(name) for name in settings.metrics)
    return ResultTable(tuple(lines), metrics, tuple(rows), cells, best_cells(rows, metrics, cells))


def _shown(value: float, digits: int) -> str:
    if value != value:
        return ""
    text = f"{value:.{digits}f}"
    # No negative zero: "-0.000" would look like a finding.
    return text.removeprefix("-") if float(text) == 0 else text


def best_cells(rows, metrics, cells) -> frozenset[tuple[str, str]]:
    """The (row, metric) pairs whose shown figure no other predicting row beats; the floor knows the truth: left out."""
    found = set()
    for metric in metrics:
        costs = {}
        for row in rows:
            text = cells[row, metric.name]["value"]
            if row != FLOOR_ROW and text:
                # Rounded, so that 0.9 and 1.1 are equally far from 1.
                costs[row] = {"low": float(text), "high": -float(text), "one": round(abs(float(text) - 1), 12)}[
                    metric.best
                ]
        if len(costs) > 1:
            found |= {(row, metric.name) for row, cost in costs.items() if cost == min(costs.values())}
    return frozenset(found)
