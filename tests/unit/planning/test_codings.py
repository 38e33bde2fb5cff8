"""Kinds of visual codings: the settings that each has, what systems may ask of them, who can speak."""

import pytest

from tests.unit.planning.configs import planned, resolved, rows
from visualspeech.errors import SettingError


def mine(**changes):
    """A system on markers beside that of an AAM."""
    own = {
        "name": "mine",
        "needs": ["audio"],
        "rate": 60,
        "coding": "markers",
        "blocks": {"mel": {"kind": "log_mel"}},
        "models": {"net": {"family": "stack", "letters": ["F"], "nodes": [8], "reads": ["mel"]}},
        "tables": {"metrics": ["gv_ratio"]},
        **changes,
    }
    return {"systems": ["fan2015", own], "corpora": ["demo"]}


def refused(*overlays):
    with pytest.raises(SettingError) as error:
        resolved(*overlays)
    return str(error.value)


def test_each_kind_has_its_own_sections():
    codings = resolved(mine())["codings"]
    assert codings["markers"] == {
        "name": "markers", "kind": "markers", "points": "landmarks_68", "markers": {"normalisation": "speaker"},
    }  # fmt: skip
    assert "markers" not in codings["aam51"] and codings["aam51"]["drift"] == {
        "method": "clip_mean", "min_silent_seconds": 0.2,
    }  # fmt: skip
    assert "`codings.markers.drift`" in refused(mine(), "override: {codings: {markers: {drift: {method: none}}}}")
    assert "`codings.aam51.markers`" in refused(mine(), "override: {codings: {aam51: {markers: {}}}}")
    assert "`codings.markers.kind: mesh`" in refused(mine(), "override: {codings: {markers: {kind: mesh}}}")
    said = refused(mine(), "override: {codings: {markers: {markers: {normalisation: none}}}}")
    assert "`codings.markers.markers.normalisation: none` must be one of" in said
    said = refused(mine(), "override: {codings: {markers: {points: iemocap_46}}}")
    assert "`codings.markers.points: iemocap_46`" in said and "landmarks_68" in said


def test_a_system_needs_what_its_coding_reads():
    systems = resolved(mine())["systems"]
    assert systems["mine"]["needs"] == ["audio", "faces"]
    assert systems["fan2015"]["needs"].count("video") == 1


def test_the_default_run_has_each_system_where_it_can_run():
    plan = planned()
    assert plan.systems("demo") == ["fan2015", "thangthai2016", "sadoughi2017"]
    assert plan.systems("demo_pair") == ["sadoughi2017"]
    assert plan.codings("demo") == ["aam51", "aam34", "markers"]
    assert rows(plan.settings, "sadoughi2017") == ["Separate-1-64", "Joint-1-64", "Separate-2-64", "Joint-2-64"]


def test_families_of_regions_need_a_coding_that_has_some():
    said = refused(mine(coding="aam51", models={"net": {"family": "joint", "reads": ["mel"]}}, tables={}))
    assert "`systems.mine.models.net.family: joint` predicts regions of the face" in said and "aam51" in said
    assert resolved(mine(models={"net": {"family": "joint", "reads": ["mel"]}}))


def test_what_a_coding_of_markers_cannot_give_is_refused():
    net = {"family": "stack", "letters": ["F"], "nodes": [8], "reads": ["mel"], "training": {"closure_weight": 2.0}}
    assert "`systems.mine.models.net.training.closure_weight` weights the opening" in refused(mine(models={"net": net}))
    assert "`systems.mine.sound_model` must be empty" in refused(mine(sound_model="net"))
    said = refused(mine(), "speak: {system: mine}")
    assert said.startswith("`speak.system: mine` cannot speak: mine predicts markers of the face")
    assert said.endswith("Systems that can: fan2015.")
    # Where no system is named, the first that can speak does.
    own = mine()
    assert resolved({**own, "systems": own["systems"][::-1]}, "speak: {model: FBB-128}")
