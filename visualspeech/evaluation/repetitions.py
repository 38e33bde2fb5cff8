"""Networks that were trained several times: what their seeds have in common, and how much they differ."""

from collections.abc import Mapping, Sequence

import numpy as np

from visualspeech.errors import DataError
from visualspeech.evaluation.metrics import METRICS, corpus_figure
from visualspeech.naming import cells_of


def pooled(tables: Mapping[str, object]) -> dict[str, object]:
    """Per-utterance tables with the seeds of a network as one row: each measure is the mean over the seeds.

    Parameters
    ----------
    tables : row name -> per-utterance table; networks are named as :mod:`visualspeech.naming` has it

    Returns
    -------
    dict
        row name (networks without their seed) -> per-utterance table, networks first, in the order given

    Raises
    ------
    DataError
        The seeds of a network were evaluated on different utterances.
    """
    cells = cells_of(tables)
    of_cells = {name for names in cells.values() for name in names}
    result = {cell: _mean([tables[name] for name in names], cell) for cell, names in cells.items()}
    return result | {name: table for name, table in tables.items() if name not in of_cells}


def _mean(tables: Sequence, cell: str):
    first, *others = tables
    if any(list(other["id"]) != list(first["id"]) for other in others):
        raise DataError(f"the seeds of {cell} were evaluated on different utterances. Delete its models and run again.")
    averaged = [name for name in (*METRICS, "corr_undefined") if name in first]
    means = {name: np.mean([table[name].to_numpy(float) for table in tables], axis=0) for name in averaged}
    return first.assign(**means) if others else first


def mean_and_deviation(tables: Sequence, metric: str) -> tuple[float, float]:
    """Mean of a corpus figure over repetitions, and its sample standard deviation; NaN of a single one."""
    figures = [corpus_figure(table, metric) for table in tables]
    return float(np.mean(figures)), float(np.std(figures, ddof=1)) if len(figures) > 1 else float("nan")
