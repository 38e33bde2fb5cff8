"""The kinds of attempts, and how one of them is run in a process of its own."""

import importlib
import tempfile
import time
from pathlib import Path

from tests.campaign.results import Result

#: Kind -> its share of the cases, by what an attempt costs and how much it can find.
KINDS = {"media": 0.2, "names": 0.2, "tables": 0.15, "states": 0.2, "commands": 0.05, "settings": 0.1, "speakers": 0.1}


def run_kind(job: tuple[str, int, int]) -> tuple[str, list[Result], float]:
    """Results of a kind, seed and count, with the kind before and the seconds after them."""
    kind, seed, count = job
    start = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="visualspeech.campaign.") as folder:
        results = importlib.import_module(f"tests.campaign.{kind}").run(Path(folder), seed, count)
    return kind, results, time.monotonic() - start
