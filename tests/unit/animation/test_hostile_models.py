"""Altered speaker folders: a sentence that names the file, or finite results."""

from collections import Counter

import pytest

from tests import hostile_models

CASES = 10_000
SLICES = 10


@pytest.fixture(scope="module")
def speaker(tmp_path_factory):
    return hostile_models.make(tmp_path_factory.mktemp("hostile"))


@pytest.mark.parametrize("seed", range(SLICES))
def test_no_alteration_is_a_crash_or_goes_unsaid(speaker, tmp_path, seed):
    outcomes = list(hostile_models.campaign(speaker, tmp_path / "work", seed, CASES // SLICES))
    assert [one for one in outcomes if one.problem] == []
    found = Counter("error" if one.error else "used" for one in outcomes)
    # The campaign must reach both: what is refused, and what is harmless.
    assert found["error"] > 0.5 * len(outcomes) and found["used"] > 0.1 * len(outcomes)
    assert {one.case.partition(":")[0] for one in outcomes} >= {*hostile_models.MODELS, "aam", "head", "background"}


def test_the_first_cases_of_a_longer_campaign_are_those_of_a_shorter_one(speaker, tmp_path):
    short, long = (list(hostile_models.campaign(speaker, tmp_path / str(count), 3, count)) for count in (5, 9))
    assert [one.case for one in long[:5]] == [one.case for one in short]
