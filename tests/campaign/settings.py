"""Extreme values at every key of the settings: each is accepted, or refused before any job with its key."""

import os
from pathlib import Path

from tests.campaign.results import Result, refused, used
from tests.settings_cases import cases, outcome

_SLOW = 10.0  # seconds; planning may not hang on a value


def run(folder: Path, seed: int, count: int) -> list[Result]:
    """Results of settings with one extreme value; nothing may be written."""
    before, results = sorted(os.listdir(folder)), []
    for case in cases(seed, count):
        said = outcome(case)
        shown = f"{case.key}: {ascii(case.value)[:60]}"
        if said.kind == "refused":
            results.append(refused(shown, said.message, case.key.split(".")))
        else:
            results.append(used(shown, wrong=said.message))
        if said.seconds > _SLOW:
            results.append(used(shown, wrong=f"planning took {said.seconds:.0f} s"))
    if sorted(os.listdir(folder)) != before:
        results.append(used("all settings", wrong="planning wrote files"))
    return results
