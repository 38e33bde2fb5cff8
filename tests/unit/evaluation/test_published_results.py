"""Published figures: sections may be absent, mistakes are named."""

import pytest

from visualspeech.errors import SettingError
from visualspeech.evaluation.metrics import METRICS
from visualspeech.evaluation.published_results import published, published_of, shared_metrics

BARE = {"source": "a paper", "corpus": "its corpus"}


def test_a_paper_without_tables_is_empty():
    paper = published_of(BARE, "bare")
    assert not (paper.metrics or paper.topologies or paper.stacks or paper.gains or paper.preference)
    assert shared_metrics(paper, [METRICS["corr"]]) == ("corr",) == shared_metrics(None, [METRICS["corr"]])
    assert shared_metrics(published("fan2015"), [METRICS["corr"]])[0] == "rmse_shape"


def test_no_key_is_no_paper_and_an_unknown_one_is_named():
    assert published("") is None
    with pytest.raises(SettingError, match="`published: fan2014` is not known. Known: fan2015"):
        published("fan2014")


def test_figures_must_fit_the_measures():
    data = BARE | {"metrics": ["corr", "ccc"], "gains": {"best": "a", "figures": {"a": [0.1]}}}
    with pytest.raises(SettingError, match="published/odd.yaml"):
        published_of(data, "odd")
    with pytest.raises(SettingError, match="unknown metric `cor`"):
        published_of(BARE | {"metrics": ["cor"]}, "odd")
