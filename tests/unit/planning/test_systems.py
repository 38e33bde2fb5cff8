"""Systems: what they extend, changes of a run, codings, and mistakes as sentences before any job."""

import pytest

from tests.unit.planning.configs import CONFIG, resolved, rows
from visualspeech.corpora.records import MAX_ID
from visualspeech.errors import SettingError
from visualspeech.fields import MAX_SEED
from visualspeech.planning.systems import NEEDS, extended, missing_needs


def system(name="mine", **more):
    return {"name": name, "extends": "fan2015", **more}


@pytest.fixture
def folder(tmp_path):
    for name, text in {
        "one": "a: 1\nb: {c: 1, d: 1}\n",
        "two": "extends: one\nb: {c: 2}\n",
        "three": "extends: two\ne: 3\n",
        "loop": "extends: back\n",
        "back": "extends: loop\n",
        "self": "extends: self\n",
    }.items():
        (tmp_path / f"{name}.yaml").write_text(text)
    return tmp_path


def test_a_chain_is_laid_over_each_other(folder):
    found = extended("three", "systems", folder, {})
    assert found == {"name": "three", "a": 1, "b": {"c": 2, "d": 1}, "e": 3}
    inline = extended({"name": "four", "extends": "three", "b": {"d": 4}}, "systems", folder, {})
    assert inline == {"name": "four", "a": 1, "b": {"c": 2, "d": 4}, "e": 3}
    path = extended(str(folder / "two.yaml"), "systems", folder, {})
    assert path == {"name": "two", "a": 1, "b": {"c": 2, "d": 1}}


def test_changes_of_a_base_count_for_what_extends_it(folder):
    override = {"one": {"a": 9, "b": {"c": 9, "d": 9}}, "three": {"e": 4}}
    assert extended("three", "systems", folder, override) == {"name": "three", "a": 9, "b": {"c": 2, "d": 9}, "e": 4}
    assert extended("one", "systems", folder, override) == {"name": "one", "a": 9, "b": {"c": 9, "d": 9}}
    assert extended("two", "systems", folder, {"three": {"e": 4}}) == {"name": "two", "a": 1, "b": {"c": 2, "d": 1}}


@pytest.mark.parametrize("name", ["loop", "back", "self"])
def test_a_chain_that_leads_back_is_refused(folder, name):
    with pytest.raises(SettingError, match=r"^`systems\.(loop|back|self).extends: .*` leads back to"):
        extended(name, "systems", folder, {})


def test_an_overlay_changes_every_rate_of_a_system():
    settings = resolved(CONFIG / "two_rates.yaml", {"override": {"systems": {"fan2015": {
        "training": {"max_epochs": 3}, "models": {"hmm_mge": None}}}}})  # fmt: skip
    for name in ("fan2015", "fan2015_50hz"):
        trained = [row for row in settings["systems"][name]["rows"] if row["family"] == "stack"]
        assert {row["training"]["max_epochs"] for row in trained} == {3} and "hmm_mge" not in rows(settings, name)
    assert (settings["systems"]["fan2015_50hz"]["rate"], settings["systems"]["fan2015"]["rate"]) == (50, 25)
    assert rows(settings, "fan2015_50hz")[0] == "FBB-128"
    only = resolved(CONFIG / "two_rates.yaml", {"override": {"systems": {"fan2015_50hz": {"rate": 100}}}})
    assert [only["systems"][name]["rate"] for name in ("fan2015", "fan2015_50hz")] == [25, 100]


def test_a_system_in_one_mapping():
    mine = {
        "name": "mine",
        "rate": 25,
        "needs": ["video"],
        "coding": {"name": "small", "extends": "aam51", "aam": {"images": 300}},
        "blocks": {"tri": {"kind": "triphone_state"}, "parts": {"kind": "label_parts", "parts": ["stress"]}},
        "models": {"nets": {"family": "stack", "letters": ["F"], "nodes": [8], "reads": ["tri", "parts"]}},
    }
    settings = resolved({"systems": ["fan2015", mine]})
    found = settings["systems"]["mine"]
    assert found["coding"] == "small" and settings["codings"]["small"]["aam"]["images"] == 300
    assert settings["codings"]["small"]["drift"] == settings["codings"]["aam51"]["drift"]
    assert settings["codings"]["aam51"]["aam"]["images"] == 20000
    assert found["blocks"] == {
        "tri": {"kind": "triphone_state", "settings": {"fractional": False, "states": "aligned"}},
        "parts": {"kind": "label_parts", "settings": {"parts": ["stress"]}},
    }
    assert [row["name"] for row in found["rows"]] == ["F-8", "training_mean", "reconstruction"]
    assert found["videos"]["model"] == "F-8" and found["preference"]["models"] == ["F-8", "training_mean"]
    assert "models" not in found and found["seeds"] == [1]
    # Labels are computed from the text, and stress from ARPAbet, whatever its file says.
    assert found["needs"] == ["video", "arpabet", "text"]


def test_a_system_of_baselines_shows_one():
    names = ("monophone", "tied", "mge")
    nets = ["nets", "nets_thirds", "sound", "text_and_sound", "articulate"]
    models = dict.fromkeys([*nets, *(f"hmm_{one}{end}" for one in names for end in ("", "_states"))])
    settings = resolved({"systems": [system(models=models, videos={"model": ""})]})
    mine = settings["systems"]["mine"]
    assert mine["videos"]["model"] == "training_mean" and mine["tables"]["topologies"] == []
    assert mine["preference"]["models"] == ["training_mean", "triphone_state_mean"]


def test_the_model_for_recordings_is_an_entry_or_a_row():
    changes = {"models": {"sound": {"nodes": [16, 32]}}}
    for name, row in {"sound": "FBB-16-mel", "FBB-32-mel": "FBB-32-mel", "": ""}.items():
        settings = resolved({"override": {"systems": {"fan2015": {**changes, "sound_model": name}}}})
        assert settings["systems"]["fan2015"]["sound_model"] == row
    settings = resolved({"override": {"systems": {"fan2015": {"models": {"sound": None, "text_and_sound": None}}}}})
    assert settings["systems"]["fan2015"]["sound_model"] == ""
    for name, said in {
        "hmm_mge": "hmm_mge reads track",
        "text_and_sound": "reads tri_shares, mel",
        "x": "is no entry of",
    }.items():
        with pytest.raises(SettingError, match=f"sound_model: {name}.*{said}"):
            resolved({"override": {"systems": {"fan2015": {"sound_model": name}}}})


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ({"hmm_monophone": {"reads": ["tri"]}}, "reads: tri` is .* of frames, and the family hmm reads segments. "
         "Known: track, track_states"),
        ({"sound": {"reads": ["mel", "track"]}}, "reads: track` is .* of segments, and the family stack reads frames. "
         "Known: tri, "),
    ],
)  # fmt: skip
def test_rows_read_segments_or_frames_as_their_family_does(entry, said):
    with pytest.raises(SettingError, match=f"`systems.fan2015.models.{next(iter(entry))}.{said}"):
        resolved({"override": {"systems": {"fan2015": {"models": entry}}}})


def test_hsmms_are_hmms_with_durations_and_full_contexts():
    changes = {
        "blocks": {"full": {"kind": "full_context"}},
        "models": {"hmm_monophone": {"durations": "gaussian", "reads": ["full"]}},
    }
    settings = resolved({"override": {"systems": {"fan2015": changes}}})
    found = {row["name"]: row for row in settings["systems"]["fan2015"]["rows"]}
    titles = ["monophone HSMM", "tied-state quinphone HSMM", "MGE-trained HSMM"]
    for name, title in zip(("hmm_monophone", "hmm_tied", "hmm_mge"), titles, strict=True):
        assert (found[name]["title"], found[name]["reads"]) == (title, ["full"])
    assert settings["systems"]["fan2015"]["blocks"]["full"]["settings"]["neighbours"] == 2
    assert found["hmm_tied_states"]["settings"]["durations"] == "geometric"


def test_a_system_driven_by_sound_needs_no_text():
    system = resolved({"systems": ["sound_driven"]})["systems"]["sound_driven"]
    assert system["needs"] == ["video", "audio", "one_speaker"] and system["sound_model"] == "FBB-128"
    assert missing_needs(system, frozenset({"video", "audio", "one_speaker"})) == []


def test_seeds_of_the_run_and_of_a_system():
    assert resolved({"seed": 7})["systems"]["fan2015"]["seeds"] == [7]
    found = resolved({"override": {"systems": {"fan2015": {"seeds": [3, 4], "models": {"nets": {"letters": ["F"]}},
                                                          "videos": {"model": "F-64-s4"}}}}})  # fmt: skip
    assert rows(found)[:4] == ["F-64", "F-128", "F-64-s4", "F-128-s4"]
    assert {row["seed"] for row in found["systems"]["fan2015"]["rows"] if row["family"] == "stack"} == {3, 4}


def test_one_coding_of_two_systems_is_one():
    settings = resolved({"systems": ["fan2015", system()]})
    assert list(settings["codings"]) == ["aam51"]
    changed = resolved({"systems": ["fan2015"], "override": {"codings": {"aam51": {"aam": {"images": 300}}}}})
    assert changed["codings"]["aam51"]["aam"]["images"] == 300


def test_two_codings_of_one_name_must_agree():
    other = system(coding={"name": "aam51", "kind": "aam", "points": "lower_face_51", "aam": {"images": 300}})
    with pytest.raises(SettingError, match="`systems.mine.coding`: another system defines a coding named aam51"):
        resolved({"systems": ["fan2015", other]})
    assert resolved({"systems": [other]})["codings"]["aam51"]["aam"]["images"] == 300


def test_what_is_missing_is_said_in_words():
    assert missing_needs({"needs": list(NEEDS)}, frozenset(NEEDS)) == []
    assert missing_needs({"needs": ["video", "text"]}, frozenset({"video"})) == ["transcripts"]


def changed(**change):
    return {"override": {"systems": {"fan2015": change}}}


def models(**entries):
    return changed(models=entries)


#: A system that extends none.
WHOLE = {
    "name": "mine", "rate": 25, "needs": ["video"], "coding": "aam51", "blocks": {"tri": {"kind": "triphone_state"}},
    "models": {"means": {"family": "lookup", "reads": ["tri"]}},
}  # fmt: skip

#: Rows of the ablation table of fan2015, with their models.
ABLATION = {
    "network": ["FBB-128-thirds", "FBB-128"],
    "tied-state triphone HMM": ["hmm_tied", "hmm_tied_states"],
    "MGE-trained HMM": ["hmm_mge", "hmm_mge_states"],
}
MISTAKES = [
    ({"systems": "fan2016"}, r"`systems: fan2016` is not known. Did you mean `fan2015.*Known: fan2015"),
    ({"systems": [3]}, r"`systems.0: 3` must be a text or lines of `key: value` .put it in quotes.. Name, path or map"),
    ({"systems": [{"rate": 3}]}, "`systems.0` lacks `name`. Folder of the results"),
    ({"systems": ["nothere.yaml"]}, "cannot read nothere.yaml"),
    ({"systems": []}, r"`systems: \[\]` must have at least 1 entry"),
    ({"systems": ["fan2015", "fan2015"]}, "`systems` names fan2015 more than once"),
    ({"systems": ["fan2015", system("Fan2015")]}, r"`systems` names Fan2015 more than once \(capitals do not count\)"),
    ({"systems": [system("Tables")]}, "`systems.Tables`: Tables is the name of a folder of the results"),
    ({"systems": [system("a/b")]}, "`systems.0.name: a/b` must be of this form: Folder of the results"),
    ({"systems": [{"name": "mine", "extends": "fan"}]}, r"`systems.mine.extends: fan` is not known. .*Did you mean"),
    ({"systems": [{"name": "mine", "extends": "mine"}]}, "`systems.mine.extends: mine` is not known. Known: fan2015"),
    ({"systems": [{key: value for key, value in WHOLE.items() if key != "coding"}]}, "`systems.mine` lacks `coding`."),
    ({"systems": [{key: value for key, value in WHOLE.items() if key != "rate"}]}, "`systems.mine` lacks `rate`. Fram"),
    ({"systems": [system(coding="aam15")]}, r"`systems.mine.coding: aam15` is not known.*Did you mean `aam51`"),
    ({"systems": [system(rat=3)]}, r"unknown setting `systems.mine.rat`. Did you mean `rate`"),
    ({"override": {"systems": {"fan2016": {}}}}, r"`override.systems: fan2016` is not known.*Did you mean `fan2015"),
    ({"override": {"codings": {"aam50": {}}}}, r"`override.codings: aam50` is not known.*Did you mean `aam51`"),
    ({"override": {"systems": {"fan2015": 3}}}, "`override.systems.fan2015: 3` must be lines of `key: value`"),
    ({"override": {"models": {}}}, "`override.models` is a setting of systems, `override.systems.fan2015.models`"),
    ({"override": {"codings": {"aam51": {"aam": {"shap": {}}}}}},
     r"unknown setting `codings.aam51.aam.shap`. Did you mean `shape`"),
    ({"override": {"codings": {"aam51": {"aam": {"shape": {"components": 200}}}}}},
     "`codings.aam51.aam.shape.components: 200` is more than there can be"),
    ({"override": {"codings": {"aam51": {"aam": {"images": 50, "texture": {"components": 80}}}}}},
     "`codings.aam51.aam.texture.components: 80` is more than there can be: 50 images"),
    ({"override": {"codings": {"aam51": {"points": "lower_face_50"}}}}, "`codings.aam51.points: lower_face_50` is no"),
    (changed(needs=["colour"]), "`systems.fan2015.needs.0: colour` must be one of video, audio, text"),
    (changed(training={"dropout": 1}), "`systems.fan2015.training.dropout: 1` must be at least 0 and below 1"),
    (changed(training={"scaling": True}), "`systems.fan2015.training.scaling: true` must be one of global"),
    (changed(blocks={"tri": {"kind": "triphone_stat"}}),
     r"`systems.fan2015.blocks.tri.kind: triphone_stat` must be one of .*Did you mean `triphone_state`"),
    (changed(blocks={"tri": {}, "x": {"phones": 3}}), "`systems.fan2015.blocks.x` lacks `kind`. Kind of input block"),
    (changed(blocks={"tri": {"phones": 3}}), "unknown setting `systems.fan2015.blocks.tri.phones`. Known here: fra"),
    (changed(blocks={"parts": {"parts": ["tone"]}}), "`systems.fan2015.blocks.parts.parts.0: tone` must be one of pos"),
    (changed(blocks={"parts": None}, models={"nets": {"reads": ["parts"]}}),
     "`systems.fan2015.models.nets.reads.0: parts` must be one of tri, tri_shares"),
    (models(nets={"reads": "tri"}), r"`systems.fan2015.models.nets.reads: tri` must be a list; write \[tri\]"),
    (models(nets={"letters": ["F"], "reads": [{"tri": 0.01}]}),
     "`systems.fan2015.models.nets.reads`: the window of tri, 0.01 s, is less than a frame of 0.04 s"),
    (models(wide={"family": "dnn", "reads": [{"track": 0.2}]}),
     "`systems.fan2015.models.wide.reads`: the window of track must be left out: the block has a row per segment"),
    (models(nets={"letters": ["BF"], "reads": [{"tri": 0.2}]}), "`systems.fan2015.models.nets.reads` has a window; a"),
    (models(nets={"seeds": []}), r"`systems.fan2015.models.nets.seeds: \[\]` must have at least 1 entry"),
    (models(nets={"suffix": "a/b"}), "`systems.fan2015.models.nets.suffix: a/b` must be of this form"),
    (models(nets={"training": 3}), "`systems.fan2015.models.nets.training: 3` must be lines of `key: value`"),
    (models(nets=3), "`systems.fan2015.models.nets: 3` must be lines of `key: value`"),
    (models(nets={"letters": ["FXB"]}), "`systems.fan2015.models.nets.letters.0: FXB` must be"),
    (models(nets={"node": 3}), r"unknown setting `systems.fan2015.models.nets.node`. Did you mean `nodes`"),
    (models(hmm_mge={"mge_epoch": 3}), r"unknown setting `systems.fan2015.models.hmm_mge.mge_epoch`. Did you mean"),
    (changed(videos={"model": "BBB-512"}), r"`systems.fan2015.videos.model: BBB-512` is no model .*Did you mean"),
    (changed(videos={"model": "reconstruction"}), "`systems.fan2015.videos.model: reconstruction` is no model"),
    (changed(preference={"models": ["FBB-128"]}), r"`systems.fan2015.preference.models: \[FBB-128\]` must name two"),
    (changed(preference={"models": ["FBB-128", "FBB"]}), "`systems.fan2015.preference.models.1: FBB` is no model"),
    (changed(tables={"topologies": ["net"]}), r"`systems.fan2015.tables.topologies.0: net` is .*Did you mean `nets`"),
    (changed(tables={"gains": {"references": ["hmm"]}}), "`systems.fan2015.tables.gains.references.0: hmm` is no entr"),
    (models(mix={"family": "ensemble", "members": ["net"]}),
     r"`systems.fan2015.models.mix.members.0: net` is no entry .*Did you mean `nets`"),
    (changed(tables={"ablation": {"rows": {"network": ["nets_thirds", "net"]}}}),
     r"`systems.fan2015.tables.ablation.rows.network.1: net` is no entry .*Did you mean `nets`"),
    (changed(tables={"ablation": {"rows": {"network": ["nets"]}}}),
     "`systems.fan2015.tables.ablation.rows.network` names 1 models; it must name one for each of the 2 `columns`"),
    (changed(tables={"ablation": {"columns": ["one"], "rows": {name: None for name in ABLATION} | {"x": ["nets"]}}}),
     "`systems.fan2015.tables.ablation.rows.x` names 1 models; .* there must be two"),
    (changed(tables={"selections": {"mine": {"rows": ["net"]}}}),
     r"`systems.fan2015.tables.selections.mine.rows.0: net` is no entry .*Did you mean `nets`"),
    (changed(tables={"selections": {"mine": {"rows": ["nets"], "reference": "hmm_mge"}}}),
     "`systems.fan2015.tables.selections.mine.reference: hmm_mge` is no row of this table. Known: nets"),
    (changed(tables={"selections": {"gains": {"rows": ["nets"]}}}),
     "`systems.fan2015.tables.selections.gains`: gains is the name of another table"),
    (changed(tables={"selections": {"mine": {"rows": ["nets"], "down": "letters"}}}),
     "`systems.fan2015.tables.selections.mine.down: letters` must be given together with `across`"),
    (changed(tables={"selections": {"mine": {"metrics": ["rmse"]}}}),
     "`systems.fan2015.tables.selections.mine.metrics.0: rmse` is no measure.* Known: rmse_shape"),
    (changed(trajectories={"models": ["FBB"]}), "`systems.fan2015.trajectories.models.0: FBB` is no model of"),
    (changed(tables={"metrics": ["rmse"]}), "`systems.fan2015.tables.metrics.0: rmse` is no measure. Known: rmse_s"),
    (changed(published="fan2016"), "fan2016"),
    (changed(seeds=[1, 1]), r"`systems.fan2015.seeds: \[1, 1\]` names 1 more than once"),
    ({"corpora": 3}, "`corpora: 3` must be a list, a text or lines of `key: value`"),
    ({"corpora": "demmo"}, r"`corpora: demmo` is not known.*Did you mean `demo`"),
    ({"corpora": ["demo", "demo"]}, "`corpora` names demo more than once"),
    ({"corpora": [{"name": "mine"}]}, "`corpora.mine` lacks `adapter`"),
    ({"corpora": [{"name": "mine", "adapter": "folder", "root": 5}]}, "`corpora.mine.root: 5` must be a text"),
    ({"split": {"train": 0.9}}, "`split`: the shares must sum to 1, they sum to 1.1"),
    ({"speak": {"system": "fan2016"}}, r"`speak.system: fan2016` is no selected system. Did you mean `fan2015`"),
    ({"speak": {"model": "FBB-12"}}, r"`speak.model: FBB-12` is no model of fan2015.*Did you mean `FBB-128`"),
    ({"sed": 3}, r"unknown setting `sed`\. Did you mean `seed`\?"),
]  # fmt: skip


@pytest.mark.parametrize(("change", "said"), MISTAKES)
def test_every_mistake_is_a_sentence(change, said):
    with pytest.raises(SettingError, match=said) as told:
        resolved(change)
    assert len(str(told.value).splitlines()) == 1


def test_an_entry_that_a_system_leaves_out_may_still_be_named():
    settings = resolved(models(hmm_mge=None))
    assert settings["systems"]["fan2015"]["tables"]["gains"]["references"] == ["hmm_monophone", "hmm_tied"]


@pytest.mark.parametrize(
    ("change", "rows"),
    [
        ({}, ABLATION),
        (changed(seeds=[1, 2]), ABLATION),
        (models(hmm_mge_states=None), {name: cells for name, cells in ABLATION.items() if name[:3] != "MGE"}),
        (changed(models={"nets": {"nodes": [64]}}, videos={"model": ""}), dict(list(ABLATION.items())[1:])),
        (models(nets_thirds={"nodes": [64, 128]}),
         {**{f"network: FBB-{n}-thirds / FBB-{n}": [f"FBB-{n}-thirds", f"FBB-{n}"] for n in (64, 128)},
          **dict(list(ABLATION.items())[1:])}),
        (changed(tables={"ablation": {"rows": dict.fromkeys(ABLATION)}}), {}),
        (changed(tables={"ablation": {"rows": {**dict.fromkeys(ABLATION), "x": ["FFF-64", "BBB-128"]}}}),
         {"x": ["FFF-64", "BBB-128"]}),
    ],
)  # fmt: skip
def test_rows_of_the_ablation_table(change, rows):
    assert resolved(change)["systems"]["fan2015"]["tables"]["ablation"]["rows"] == rows


def test_the_longest_name_of_a_model_fits_in_a_file_system():
    nets = {"letters": ["F" * 16], "nodes": [4096], "suffix": "s" * 32, "seeds": [1, MAX_SEED]}
    entry = {"family": "lookup", "reads": ["tri"], "suffix": "s" * 32}
    changes = {"models": {"nets": nets, "e" * 64: entry}, "videos": {"model": "training_mean"}}
    longest = resolved({"override": {"systems": {"fan2015": changes}}})
    names = [row["name"] for row in longest["systems"]["fan2015"]["rows"]]
    assert 64 + 33 == len(max(names, key=len)) < MAX_ID
    with pytest.raises(SettingError, match=r"nets.letters.0: F{80}.*at most 16"):
        resolved({"override": {"systems": {"fan2015": {"models": {"nets": {"letters": ["F" * 300]}}}}}})


def test_tables_of_chosen_rows_name_rows_and_their_reference():
    plain = resolved({"systems": ["thangthai2016"]})["systems"]["thangthai2016"]
    units, layers = plain["tables"]["selections"]["units"], plain["tables"]["selections"]["layers"]
    assert (
        units["rows"][:3] == ["hsmm", "hsmm_mge", "phone"]
        and units["reference"] == "phone"
        and units["rows"][-1] == "training_mean"
    )
    grid = [row["name"] for row in plain["rows"] if row["group"] == "grid"]
    assert layers["rows"] == grid and len(grid) == 4
    left_out = resolved({"systems": ["thangthai2016"], "override": {"systems": {"thangthai2016": {
        "models": {"grid": None}, "tables": {"selections": {"units": None}}}}}})  # fmt: skip
    tables = left_out["systems"]["thangthai2016"]["tables"]["selections"]
    assert "units" not in tables and tables["layers"]["rows"] == []


def test_rows_that_read_the_recorded_face_are_told_apart():
    plain = resolved({"systems": ["thangthai2016"]})["systems"]["thangthai2016"]
    roles = {row["name"]: row["role"] for row in plain["rows"]}
    assert {name for name, role in roles.items() if role == "oracle"} == {
        "dv_oracle", "phone_dv_oracle", *(row["name"] for row in plain["rows"] if row["group"] == "grid")
    }  # fmt: skip
    assert roles["phone_dv_predicted"] == roles["phone"] == roles["hsmm"] == "model"
    assert plain["preference"]["models"] == ["phone", "hsmm"]
