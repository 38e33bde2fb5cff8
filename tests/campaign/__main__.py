"""A long campaign, for before a release: ``python -m tests.campaign --cases 5000 [--seed 1] [--kinds media names]``.

Prints, as a table in Markdown, how many attempts of each kind were used and refused, and then each wrong answer; the
exit status is 1 if there is one.
"""

import argparse
import importlib
import os
import sys
import tempfile
import time
from multiprocessing import get_context
from pathlib import Path

from tests.campaign.results import Result

#: Kind -> its share of the cases, by what an attempt costs and how much it can find.
KINDS = {"media": 0.2, "names": 0.2, "tables": 0.15, "states": 0.2, "commands": 0.05, "settings": 0.1, "speakers": 0.1}


def main() -> int:
    """Run a campaign; returns the exit status."""
    parser = argparse.ArgumentParser(prog="python -m tests.campaign", description=__doc__.split("\n")[0])
    parser.add_argument("--cases", type=int, default=5000, help="attempts of all kinds (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="another seed makes other attempts (default: %(default)s)")
    parser.add_argument("--kinds", nargs="+", default=list(KINDS), choices=KINDS, metavar="KIND", help=", ".join(KINDS))
    given = parser.parse_args()
    share = sum(KINDS[kind] for kind in given.kinds)
    jobs = [(kind, given.seed, max(1, round(given.cases * KINDS[kind] / share))) for kind in given.kinds]
    print(
        "| kind | cases | used | refused with a sentence | answered wrongly | seconds |\n|---|---:|---:|---:|---:|---:|"
    )
    wrong = []
    # Processes of their own: what one kind leaves behind, or dies of, does not reach another.
    with get_context("spawn").Pool(min(len(jobs), os.cpu_count() or 1), maxtasksperchild=1) as pool:
        for kind, results, seconds in pool.imap(_run, jobs):
            faults = [one for one in results if one.wrong]
            refusals = sum(one.refused for one in results if not one.wrong)
            print(
                f"| {kind} | {len(results)} | {len(results) - refusals - len(faults)} | {refusals} | {len(faults)} "
                f"| {seconds:.0f} |",
                flush=True,
            )
            wrong += [(kind, one) for one in faults]
    for kind, one in wrong:
        print(f"\n{kind}: {one.case}\n    {one.wrong}")
    return 1 if wrong else 0


def _run(job: tuple[str, int, int]) -> tuple[str, list[Result], float]:
    kind, seed, count = job
    start = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="visualspeech.campaign.") as folder:
        results = importlib.import_module(f"tests.campaign.{kind}").run(Path(folder), seed, count)
    return kind, results, time.monotonic() - start


if __name__ == "__main__":
    sys.exit(main())
