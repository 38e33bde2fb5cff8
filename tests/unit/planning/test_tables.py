"""What tables may ask of a visual coding."""

import pytest

from visualspeech.evaluation.metrics import METRICS, REGIONAL
from visualspeech.planning.tables import coding_mistakes, resolved_tables, table_mistakes

EMPTY = {
    "metrics": ["gv_ratio"],
    "selections": {},
    "topologies": [],
    "gains": {"candidates": [], "references": []},
    "ablation": {"columns": [], "rows": {}},
    "regions": {"rows": []},
    "emotions": {"rows": [], "min_utterances": 2},
    "latex": {"rows": [], "metrics": []},
}


def selection(**changes):
    return {"rows": ["a"], "metrics": ["gv_ratio"], "intervals": [], "reference": ""} | changes


def test_measures_of_regions_are_those_of_codings_with_regions():
    regional, whole = list(REGIONAL), [name for name in METRICS if name not in REGIONAL]
    assert coding_mistakes(EMPTY | {"metrics": [*regional, "gv_ratio"]}, "markers", "x") == []
    assert coding_mistakes(EMPTY | {"metrics": whole}, "aam", "x") == []
    (said,) = coding_mistakes(EMPTY | {"metrics": ["rmse_shape", "corr", "ccc_upper"]}, "markers", "x.tables")
    assert said.startswith(
        "`x.tables.metrics`: rmse_shape, corr are no measures of a visual coding of the kind markers."
    )
    assert "ccc_lower_turn_absolute" in said and "rmse_texture" not in said
    (said,) = coding_mistakes(EMPTY | {"metrics": ["mse_upper", "corr"]}, "aam", "x.tables")
    assert said.startswith("`x.tables.metrics`: mse_upper is no measure")


def test_measures_of_selections_are_checked_where_they_have_rows():
    wrong = {"one": selection(intervals=["corr"])}
    (said,) = coding_mistakes(EMPTY | {"selections": wrong}, "markers", "x")
    assert said.startswith("`x.selections.one.intervals`: corr is no measure")
    none = {"one": selection(rows=[], metrics=["corr"])}
    assert coding_mistakes(EMPTY | {"selections": none}, "markers", "x") == []


@pytest.mark.parametrize(
    ("kind", "name", "given"),
    [
        ("aam", "regions", {"rows": ["a"]}),
        ("aam", "emotions", {"rows": ["a"], "min_utterances": 2}),
        ("markers", "topologies", ["a"]),
        ("markers", "gains", {"candidates": ["a"], "references": []}),
    ],
)
def test_tables_that_a_coding_has_not(kind, name, given):
    other = {"aam": "markers", "markers": "aam"}[kind]
    (said,) = coding_mistakes(EMPTY | {name: given}, kind, "x")
    assert said == f"`x.{name}`: there is no such table for a visual coding of the kind {kind}; leave it empty."
    assert coding_mistakes(EMPTY | {name: given}, other, "x") == []


def test_rows_of_the_tables_by_region_are_known_and_resolved():
    from tests.unit.evaluation.examples import stack

    tables = EMPTY | {"regions": {"rows": ["nets"]}, "emotions": {"rows": ["F-8", "lost"], "min_utterances": 2}}
    rows = [stack("F-8", "F", 8), stack("B-8", "B", 8)]
    (said,) = table_mistakes(tables, ["nets", "F-8", "B-8"], "x")
    assert "`x.emotions.rows.1" in said and "lost" in said
    resolved = resolved_tables(tables, rows)
    assert resolved["regions"]["rows"] == ["F-8", "B-8"] and resolved["emotions"]["rows"] == ["F-8"]
    assert resolved["emotions"]["min_utterances"] == 2
