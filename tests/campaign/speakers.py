"""Altered speaker folders and models: each gives finite faces, or is refused by the name of its file."""

from pathlib import Path

from tests import hostile_models
from tests.campaign.results import Result, refused, used


def run(folder: Path, seed: int, count: int) -> list[Result]:
    """Results of altered speaker folders; see :mod:`tests.hostile_models`."""
    source = hostile_models.make(folder / "speakers")
    results = []
    for one in hostile_models.campaign(source, folder / "altered", seed, count):
        if one.problem:
            results.append(used(one.case, one.error, one.problem))
        else:
            results.append(refused(one.case, one.error, [str(folder)]) if one.error else used(one.case))
    return results
