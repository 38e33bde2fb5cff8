"""Cost of the measures by region of the face: measuring, size and reading of their statistics, intervals and a test.

Run: python -m benchmarks.region_statistics [UTTERANCES [FRAMES]]

138 parameters in three regions, as of IEMOCAP's markers; made-up predictions of UTTERANCES (1000) of FRAMES (500) each.
Prints processor seconds on one thread; intervals of all measures of a row also with sums column by column.
"""

import tempfile
import time
from pathlib import Path

import numpy as np

from benchmarks.command import run_main
from visualspeech.evaluation import statistics
from visualspeech.evaluation.comparisons import ComparisonSettings, exchange_test
from visualspeech.evaluation.metrics import METRICS, REGIONAL, statistics_of
from visualspeech.evaluation.regions import region_statistics
from visualspeech.evaluation.scoring import score_table
from visualspeech.storage.tables import read_numbers, write_table

REGIONS = {"upper": range(57), "middle": range(57, 93), "lower": range(93, 138)}


def seconds(name: str, function):
    """What a function returns; its processor time is printed."""
    begin = time.process_time()
    made = function()
    print(f"{name}: {time.process_time() - begin:.2f} s", flush=True)
    return made


def measured(utterances: int, frames: int):
    """The table of statistics of made-up predictions."""
    random = np.random.default_rng(1)
    rows = []
    for number in range(utterances):
        true = random.normal(size=(frames, 138))
        rows.append(region_statistics(f"u{number:05}", 0.3 * true + 0.1, true, 120.0, REGIONS))
    return score_table(rows)


def main(utterances: int = 1000, frames: int = 500) -> None:
    import scipy.sparse
    import scipy.stats  # noqa: F401  what is imported once is not part of a figure

    table = seconds("measuring", lambda: measured(utterances, frames))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "statistics.tsv")
        seconds("writing", lambda: write_table(path, table))
        print(f"{table.shape[1]} columns, {path.stat().st_size / 1e6:.1f} MB")
        table = seconds("reading", lambda: read_numbers(path))
    drawn = statistics.draws(utterances, statistics.BootstrapSettings())
    seconds("intervals of a row", lambda: [statistics.sample(table, one, drawn) for one in REGIONAL.values()])
    wide, statistics.WIDE = statistics.WIDE, 10_000
    seconds("... column by column", lambda: [statistics.sample(table, one, drawn) for one in REGIONAL.values()])
    statistics.WIDE = wide
    metric = METRICS["ccc_upper_absolute"]
    first = statistics_of(table, metric)
    seconds("test of two rows", lambda: exchange_test(metric, first, 1.01 * first, ComparisonSettings()))


if __name__ == "__main__":
    run_main(main, __doc__)
