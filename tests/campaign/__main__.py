"""A long campaign, for before a release: ``python -m tests.campaign --cases 5000 [--seed 1] [--kinds media names]``.

Prints, as a table in Markdown, how many attempts of each kind were used and refused, and then each wrong answer; the
exit status is 1 if there is one.
"""

import argparse
import os
import sys
from multiprocessing import get_context

from tests.campaign.kinds import KINDS, run_kind


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
        for kind, results, seconds in pool.imap(run_kind, jobs):
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


if __name__ == "__main__":
    sys.exit(main())
