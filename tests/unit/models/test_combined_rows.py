"""Rows that are made of other rows: what their names stand for, what they read, and every mistake as a sentence."""

import pytest

from tests.unit.models.test_registry import HMM, NETS, names, row, rows
from visualspeech.errors import SettingError
from visualspeech.models.combined_settings import MAX_DEPTH, MAX_MEMBERS
from visualspeech.models.families import FAMILIES
from visualspeech.models.registry import code_modules

LOOKUP = {"family": "lookup", "reads": ["tri"]}


def mix(*members, **more):
    return {"family": "ensemble", "members": list(members), **more}


def gv(parent, **more):
    return {"family": "gv_compensation", "from": parent, **more}


def test_an_entry_stands_for_all_of_its_rows_and_a_row_for_itself():
    models = {"nets": {**NETS, "letters": ["F"]}, "hmm": HMM, "all": mix("nets", "hmm"), "two": mix("F-64", "F-128-s5")}
    found = row(models, "all", seeds=(1, 5))
    assert found.parents == ("F-64", "F-128", "F-64-s5", "F-128-s5", "hmm") and found.reads == ("tri", "track")
    assert row(models, "two", seeds=(1, 5)).parents == ("F-64", "F-128-s5")
    assert (found.role, found.family, found.training, found.title) == ("model", "ensemble", {}, "all")
    assert names(models, seeds=(1, 5))[-2:] == ["all", "two"]


def test_members_count_once_and_lookups_may_be_among_them():
    models = {"nets": NETS, "means": LOOKUP, "mix": mix("FBB-64", "nets", "means")}
    assert row(models, "mix").parents == ("FBB-64", "FBB-128", "F-64", "F-128", "means")


def test_entries_may_stand_before_what_they_are_made_of():
    models = {"top": mix("low", "hmm"), "low": mix("F-64"), "nets": NETS, "hmm": HMM}
    assert row(models, "top").parents == ("low", "hmm") and row(models, "top").reads == ("tri", "track")
    assert names(models) == ["top", "low", "FBB-64", "FBB-128", "F-64", "F-128", "hmm"]


def test_compensation_of_a_row_and_of_every_seed_of_an_entry():
    models = {"net": {**NETS, "letters": "F", "nodes": 8}, "gv": gv("net"), "one": gv("net-s5", strength=1.0)}
    assert [one for one in names(models, seeds=(1, 5))] == ["net", "net-s5", "gv", "gv-s5", "one"]
    assert [row(models, name, seeds=(1, 5)).parents for name in ("gv", "gv-s5", "one")] == [
        ("net",), ("net-s5",), ("net-s5",)]  # fmt: skip
    assert [row(models, name, seeds=(1, 5)).seed for name in ("gv", "gv-s5", "one")] == [1, 5, 5]
    assert {row(models, name, seeds=(1, 5)).cell for name in ("gv", "gv-s5")} == {"gv"}
    half = row(models, "gv", seeds=(1, 5))
    assert half.settings == {"strength": 0.5} and half.reads == ("tri",)


def test_compensation_takes_over_nothing_of_what_it_is_made_from_and_can_be_taken_over():
    models = {"hmm": {**HMM, "title": "First"}, "half": gv("hmm"), "full": {"like": "half", "strength": 1.0},
              "other": {"like": "half", "from": "mix"}, "mix": mix("hmm")}  # fmt: skip
    assert row(models, "half").title == "half" and row(models, "half").settings == {"strength": 0.5}
    assert row(models, "full").settings == {"strength": 1.0} and row(models, "full").parents == ("hmm",)
    assert row(models, "other").parents == ("mix",) and row(models, "other").reads == ("track",)


def test_hmms_are_made_from_the_row_of_an_entry_with_a_suffix():
    models = {"hmm": {**HMM, "suffix": "a"}, "tied": {"from": "hmm", "variant": "tied", "suffix": "b"}}
    assert row(models, "tied-b").parents == ("hmm-a",)


def test_the_code_of_a_row_is_that_of_all_that_it_is_made_of():
    models = {"nets": NETS, "hmm": HMM, "mix": mix("nets", "half"), "half": gv("hmm")}
    found = {one.name: code_modules(one, rows(models)) for one in rows(models) if one.role == "model"}
    families = {name: FAMILIES[name].module for name in ("stack", "hmm", "ensemble", "gv_compensation")}
    assert found["FBB-64"] == [families["stack"]]
    assert found["half"] == sorted([families["hmm"], families["gv_compensation"]])
    assert found["mix"] == sorted(families.values())


NET = {**NETS, "letters": "F", "nodes": 8}
DEEP = {"net": NET, **{f"m{n}": mix("net" if n == 1 else f"m{n - 1}") for n in range(1, MAX_DEPTH + 1)}}


@pytest.mark.parametrize(
    ("models", "said"),
    [
        ({"nets": NETS, "mix": mix("net")}, r"`models.mix.members.0: net` is no entry of `models` and no row.*`nets`"),
        ({"nets": NETS, "mix": mix("FBB-65")}, r"`models.mix.members.0: FBB-65` is no entry .*Did you mean `FBB-64`"),
        ({"net": NET, "half": gv("nett")}, r"`models.half.from: nett` is no entry of `models` and no row.*`net`"),
        ({"a": mix("b"), "b": mix("a")}, "`models.a.members.0: b` leads back to a; name another entry or row"),
        ({"net": NET, "a": mix("net", "b"), "b": gv("a")}, "`models.a.members.1: b` leads back to a"),
        ({"a": mix("a")}, "`models.a.members.0: a` leads back to a"),
        ({"half": gv("half")}, "`models.half.from: half` leads back to half"),
        ({"mix": mix("reconstruction")}, "`models.mix.members.0: reconstruction` is a floor, not a prediction"),
        ({"mix": mix("training_mean")}, "`models.mix.members.0: training_mean` is a baseline that reads no input bl"),
        ({"half": gv("reconstruction")}, "`models.half.from: reconstruction` is a floor"),
        ({"mix": mix()}, r"`models.mix.members: \[\]` must name at least one entry or row"),
        ({"mix": {"family": "ensemble"}}, r"`models.mix.members: \[\]` must name at least one entry or row"),
        ({"net": NET, "mix": mix("net", "net")}, "`models.mix.members: .*` names net more than once"),
        ({"net": NET, "half": {"family": "gv_compensation"}}, "`models.half` lacks `from`: .* Known: net"),
        ({"nets": NETS, "half": gv("nets")}, r"`models.half.from: nets` stands for several models \(FBB-64, FBB-128, "),
        ({"net": NET, "mix": mix("net", reads=["tri"])}, "`models.mix.reads` must be left out: .*`members` names"),
        ({"net": NET, "half": gv("net", reads=["tri"])}, "`models.half.reads` must be left out: .*`from` names"),
        ({"net": NET, "half": gv("net", seeds=[1])}, "`models.half.seeds` is for networks"),
        ({"net": NET, "half": gv("net", strength=1.5)}, "`models.half.strength: 1.5` must be at least 0 and at most 1"),
        ({"net": NET, "half": gv("net", letters="F")}, "unknown setting `models.half.letters`"),
        ({"net": NET, "half": {"from": "net", "family": "ensemble"}}, "`models.half.family: ensemble` must be stack"),
        ({"net": NET, "half": gv(["net"])}, r"`models.half.from: \[net\]` must be"),
        ({"net": NET, "half": gv("net"), "b": {"like": "c"}}, "`models.b.like: c` is no entry"),
        (DEEP, f"`models.m{MAX_DEPTH}.members.0: m{MAX_DEPTH - 1}` is made of rows .* more than {MAX_DEPTH} deep"),
        ({"nets": {**NET, "seeds": list(range(60))}, "more": {**NET, "seeds": list(range(60)), "suffix": "b"},
          "mix": mix("nets", "more")}, f"`models.mix.members` stands for 120 rows; .* at most {MAX_MEMBERS}"),
    ],
)  # fmt: skip
def test_every_mistake_is_a_sentence(models, said):
    with pytest.raises(SettingError, match=said):
        rows(models)


def test_two_unknown_names_are_two_sentences():
    with pytest.raises(SettingError) as caught:
        rows({"net": NET, "mix": mix("one", "net", "two")})
    assert [line.split("`")[1] for line in str(caught.value).splitlines()] == [
        "models.mix.members.0: one", "models.mix.members.2: two"]  # fmt: skip
