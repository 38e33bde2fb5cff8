"""Viewing tests are planned: conditions become rows, and what cannot be made is said where it is asked for."""

import pytest
import yaml

from tests.paths import REPOSITORY
from visualspeech.errors import SettingError
from visualspeech.planning.run import resolve
from visualspeech.settings import merged

CONFIG = REPOSITORY / "config"


def planned(**changes):
    settings = yaml.safe_load((CONFIG / "config.yaml").read_text())
    return resolve(merged(settings, changes), CONFIG)["studies"]


def study(**changes):
    plain = {"name": "mine", "kind": "preference", "system": "fan2015", "conditions": ["FBB-128", "hmm_mge"]}
    return planned(studies=[{**plain, **changes}])["mine"]


def test_the_presets_are_those_of_the_papers():
    found = planned()
    assert [one["problem"] for one in found.values()] == ["", "", ""]
    fan, thangthai, sadoughi = found.values()
    assert fan["settings"]["utterances"] == 10 and not fan["settings"]["forced"] and fan["published"] == "fan2015"
    assert [one["model"] for one in fan["conditions"]] == ["FBB-128", "hmm_mge"]
    assert thangthai["settings"]["utterances"] == 20 and thangthai["settings"]["forced"]
    assert [one["model"] for one in sadoughi["conditions"]] == [
        "", "Separate-1-64", "Joint-1-64", "Separate-2-64", "Joint-2-64",
    ]  # fmt: skip
    assert [one["name"] for one in sadoughi["conditions"]][0] == "recorded"
    assert list(sadoughi["settings"]["questions"]) == ["overall", "eyebrows", "lips"]


def test_systems_can_be_compared():
    other = {"model": "phone", "system": "thangthai2016", "title": "DNN"}
    found = study(conditions=["FBB-128", other])
    assert found["conditions"][1] == {
        "title": "DNN", "system": "thangthai2016", "model": "phone", "coding": "aam34", "name": "phone",
    }  # fmt: skip
    means = [{"model": "training_mean", "system": name} for name in ("fan2015", "thangthai2016")]
    assert [one["name"] for one in study(conditions=means)["conditions"]] == [
        "fan2015-training_mean", "thangthai2016-training_mean",
    ]  # fmt: skip


def test_what_a_changed_run_lacks_stops_no_other_target():
    assert study(conditions=["FBB-128", "FBB-129"])["problem"].startswith("`studies.mine.conditions.1: FBB-129` is no")
    assert "is 8 models; name one: FFF-64" in study(conditions=["nets", "hmm_mge"])["problem"]
    found = planned(systems=["fan2015"])["sadoughi2017"]
    assert found["skipped"] and "compares models of sadoughi2017, which is not selected" in found["problem"]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"conditions": ["FBB-128", "FBB-128"]}, "names one condition twice"),
        ({"conditions": ["FBB-128", "FBB-64", "hmm_mge"]}, "must name two conditions"),
        ({"conditions": ["FBB-128"]}, "at least 2"),
        ({"conditions": ["FBB-128", {"model": "joint_1", "system": "sadoughi2017"}]}, "of systems of one kind"),
        ({"kind": "survey"}, "`studies.mine.kind: survey` must be one of"),
        ({"utterances": 0}, "studies.mine.utterances: 0`? must be at least 1"),
        ({"kind": "rating", "forced": True}, "studies.mine.forced"),
        ({"questions": {"a": "?", "b": "?"}}, "one question in a preference test"),
        ({"questions": {"A b": "?"}}, "questions"),
        ({"published": "fan2014"}, "studies.mine.published: fan2014` is no"),
        ({"colour": "red"}, "colour"),
        ({"name": "../x"}, "name"),
    ],
)
def test_a_wrong_study_is_refused_in_a_sentence(changes, message):
    with pytest.raises(SettingError, match=message):
        study(**changes)


def test_studies_are_changed_by_name():
    found = planned(override={"studies": {"fan2015": {"utterances": 3}}})
    assert found["fan2015"]["settings"]["utterances"] == 3
    with pytest.raises(SettingError, match="studies"):
        planned(override={"studies": {"fan2016": {"utterances": 3}}})
    with pytest.raises(SettingError, match="more than once"):
        planned(studies=["fan2015", "fan2015"])
