"""The rows that a system's `models` asks for, and the families that its entries name."""

import importlib
import json
import sys
from dataclasses import asdict

import numpy as np
import pytest

from tests.unit.models.examples import BLOCKS, Values, task, utterances
from visualspeech.errors import SettingError, StorageError
from visualspeech.fields import Settings
from visualspeech.models import families, mean
from visualspeech.models.entries import ENTRY_KEYS
from visualspeech.models.families import FAMILIES, Family
from visualspeech.models.registry import ALWAYS, expand, load_model
from visualspeech.models.rows import ROLES, ModelRow
from visualspeech.models.stack_settings import StackSettings
from visualspeech.models.training_settings import training_settings
from visualspeech.schema import settings_class
from visualspeech.storage.models import write_model

INPUTS = {"tri": {}, "track": {}, "parts": {}}
NETS = {"family": "stack", "letters": ["FBB", "F"], "nodes": [64, 128], "reads": ["tri"]}
DNN = {"family": "dnn", "layers": [1, 3], "nodes": [64], "reads": [{"tri": 0.16}, "parts"]}
SHUFFLED = {"batcher": "shuffled_frames", "objective": "mse"}
HMM = {"family": "hmm", "variant": "monophone", "reads": ["track"]}


def rows(models, training=None, seeds=(1,), blocks=INPUTS):
    return expand(models, blocks, training or {}, list(seeds), "models")


def names(models, role="model", **more):
    return [row.name for row in rows(models, **more) if row.role == role]


def row(models, name, **more):
    return next(one for one in rows(models, **more) if one.name == name)


def test_a_grid_gives_a_row_for_each_combination():
    assert names({"nets": NETS}) == ["FBB-64", "FBB-128", "F-64", "F-128"]
    one = row({"nets": NETS}, "FBB-128")
    assert (one.group, one.cell, one.title, one.role, one.family) == ("nets", "FBB-128", "FBB-128", "model", "stack")
    assert one.settings == asdict(StackSettings("FBB", 128)) and one.reads == ("tri",)


def test_an_entry_without_a_list_has_its_own_name():
    one = row({"joint": {**NETS, "letters": "FBB", "nodes": 64}}, "joint")
    assert (one.cell, one.title, one.settings["letters"]) == ("joint", "joint", "FBB")
    assert names({"nets": {**NETS, "letters": "BB", "nodes": [8]}}) == ["BB-8"]
    assert row({"joint": {**NETS, "letters": "F", "nodes": 8, "title": "Joint"}}, "joint").title == "Joint"


def test_a_grid_of_layers_and_nodes_with_windows():
    assert names({"dnn": DNN}, training=SHUFFLED) == ["DNN-1x64", "DNN-3x64"]
    one = row({"dnn": {**DNN, "training": SHUFFLED}}, "DNN-3x64")
    assert (one.reads, one.windows, one.settings["layers"]) == (("tri", "parts"), {"tri": 0.16}, 3)
    assert one.inputs == ("tri (0.16 s either side)", "parts")
    assert one.plain()["windows"] == {"tri": 0.16} and one.training["batcher"] == "shuffled_frames"
    inherited = row({"dnn": DNN, "more": {"like": "dnn", "suffix": "b"}}, "DNN-1x64-b")
    assert inherited.windows == {"tri": 0.16}
    narrow = row({"dnn": DNN, "more": {"like": "dnn", "reads": ["tri"], "suffix": "b"}}, "DNN-1x64-b")
    assert (narrow.reads, narrow.windows) == (("tri",), {})
    assert row({"net": {**NETS, "letters": ["FBB"], "reads": [{"tri": 1}]}}, "FBB-64").windows == {"tri": 1.0}


def test_rows_without_windows_have_no_key_for_them():
    assert all(
        "windows" not in one.plain() for one in rows({"nets": NETS, "hmm": HMM, "dnn": {**DNN, "reads": ["tri"]}})
    )


def test_rows_made_of_rows_with_windows_read_their_blocks():
    mix = {"family": "ensemble", "members": ["dnn", "hmm"]}
    found = row({"dnn": DNN, "hmm": HMM, "mix": mix, "gv": {"family": "gv_compensation", "from": "DNN-1x64"}}, "mix")
    assert (found.reads, found.windows) == (("tri", "parts", "track"), {})


def test_seeds_repeat_networks_alone():
    models = {"nets": {**NETS, "letters": ["F"]}, "hmm": HMM}
    assert names(models, seeds=(1, 5)) == ["F-64", "F-128", "F-64-s5", "F-128-s5", "hmm"]
    repeated = row(models, "F-64-s5", seeds=(1, 5))
    assert (repeated.cell, repeated.seed, repeated.group) == ("F-64", 5, "nets")
    assert row(models, "hmm", seeds=(3, 5)).seed == 3 and row(models, "F-64", seeds=(3, 5)).seed == 3
    models["nets"] = {**models["nets"], "seeds": [7, 8]}
    assert names(models, seeds=(1, 5)) == ["F-64", "F-128", "F-64-s8", "F-128-s8", "hmm"]


def test_a_suffix_tells_rows_of_one_grid_apart():
    rich = {"like": "nets", "reads": ["tri", "parts"], "suffix": "rich"}
    found = names({"nets": NETS, "rich": rich})
    assert found[:4] == ["FBB-64", "FBB-128", "F-64", "F-128"]
    assert found[4:] == ["FBB-64-rich", "FBB-128-rich", "F-64-rich", "F-128-rich"]
    assert row({"nets": NETS, "rich": rich}, "F-64-rich").reads == ("tri", "parts")
    assert "F-64-rich-s2" in names({"nets": NETS, "rich": rich}, seeds=(1, 2))


def test_like_takes_over_settings_and_from_a_model_too():
    chain = {
        "hmm": {**HMM, "states": 3, "title": "First"},
        "tied": {"from": "hmm", "variant": "tied"},
        "mge": {"from": "tied", "variant": "mge", "states": 4},
        "other": {"like": "mge", "mge_epochs": 2},
    }
    found = {one.name: one for one in rows(chain)}
    assert found["tied"].settings["states"] == 3 and found["mge"].settings["states"] == 4
    assert [found[name].parents for name in chain] == [(), ("hmm",), ("tied",), ("tied",)]
    assert found["other"].settings["variant"] == "mge" and found["other"].reads == ("track",)
    assert [found[name].title for name in ("hmm", "tied", "mge")] == [
        "First", "tied-state triphone HMM", "MGE-trained HMM",
    ]  # fmt: skip


def test_settings_of_training_are_merged_over_those_of_the_system():
    models = {"nets": {**NETS, "letters": "F", "nodes": 8, "training": {"dropout": 0.1, "patience": 3}},
              "more": {"like": "nets", "training": {"dropout": 0.2}}}  # fmt: skip
    found = {one.name: one for one in rows(models, training={"optimiser": "paper", "patience": 9, "max_epochs": 2})}
    assert found["nets"].training["dropout"] == 0.1 and found["more"].training["dropout"] == 0.2
    for one in (found["nets"], found["more"]):
        assert (one.training["patience"], one.training["max_epochs"]) == (3, 2)
        # What is not given is that of the preset.
        assert one.training["initial_std"] == training_settings(optimiser="paper").initial_std
        assert "seed" not in one.training
    assert found["training_mean"].training == {}


def test_none_leaves_an_entry_out():
    assert names({"nets": NETS, "hmm": None}) == names({"nets": NETS})
    with pytest.raises(SettingError, match="`models.tied.from: hmm` is no entry of `models`. Known: nets."):
        rows({"nets": NETS, "hmm": None, "tied": {"from": "hmm", "variant": "tied"}})


def test_every_system_has_the_training_mean_and_the_floor():
    assert [one.name for one in rows({})] == ["training_mean", "reconstruction"]
    assert [one.role for one in rows({})] == ["baseline", "floor"]
    assert rows({"training_mean": None})[0].name == "training_mean"
    assert row({"training_mean": {"family": "mean", "title": "Average"}}, "training_mean").title == "Average"


def test_models_come_before_baselines_and_the_floor():
    lookup = {"family": "lookup", "reads": ["tri"]}
    found = rows({"means": lookup, "nets": {**NETS, "letters": ["F"]}, "hmm": HMM})
    assert [one.name for one in found] == ["F-64", "F-128", "hmm", "means", "training_mean", "reconstruction"]
    assert [one.role for one in found] == sorted((one.role for one in found), key=ROLES.index)


def test_rows_are_plain_data_and_come_back():
    for one in rows({"nets": NETS, "hmm": HMM, "dnn": DNN}):
        assert ModelRow.of(json.loads(json.dumps(one.plain()))) == one


@pytest.mark.parametrize(
    ("models", "said"),
    [
        ({"nets": {**NETS, "family": "stak"}}, "`models.nets.family: stak` .*Did you mean `stack`"),
        ({"nets": {"letters": "F"}}, "`models.nets` lacks `family`. Family .* Known: stack, hmm"),
        ({"nets": {**NETS, "node": 3}}, r"unknown setting `models.nets.node`. Did you mean `nodes`\? Known"),
        ({"nets": {**NETS, "seed": 3}}, "unknown setting `models.nets.seed`"),
        ({"nets": {**NETS, "reads": ["trj"]}}, r"`models.nets.reads.0: trj` must be one of tri, .*Did you mean `tri`"),
        ({"nets": {**NETS, "reads": []}}, r"`models.nets.reads: \[\]` must have at least 1 entry"),
        ({"hmm": {"family": "hmm"}}, "`models.hmm` lacks `reads`. Input blocks .* Known: tri, track, parts"),
        ({"m": {"family": "mean", "reads": ["tri"]}}, "`models.m.reads` must be left out"),
        ({"nets": {**NETS, "letters": ["FXB"]}}, "`models.nets.letters.0: FXB` must be of this form: Hidden layers"),
        ({"nets": {**NETS, "letters": []}}, r"`models.nets.letters: \[\]` must have at least 1 entry"),
        ({"nets": {**NETS, "nodes": [0]}}, "`models.nets.nodes.0: 0` must be at least 1"),
        ({"nets": {**NETS, "nodes": 15, "b_nodes": "layer"}}, "`models.nets.nodes: 15` must be even: with `b_nodes: l"),
        ({"nets": {**NETS, "training": {"dropout": 1}}}, "`models.nets.training.dropout: 1` must be"),
        ({"nets": {**NETS, "training": {"drop": 1}}}, "unknown setting `models.nets.training.drop`. Did you mean `dro"),
        ({"hmm": {**HMM, "training": {"dropout": 0}}}, "`models.hmm.training` is for networks; the family hmm is trai"),
        ({"hmm": {**HMM, "variant": "triphone"}}, "`models.hmm.variant: triphone` must be one of monophone"),
        ({"nets": {**NETS, "letters": ["F", "F"]}}, r"`models.nets.letters: \[F, F\]` names F more than once"),
        ({"nets": NETS, "more": {"like": "nets"}}, "`models.more`: two rows are named FBB-64"),
        ({"nets": NETS, "more": {"like": "net"}}, r"`models.more.like: net` is no entry of `models`.*Did you mean `ne"),
        ({"a": {"like": "b"}, "b": {"from": "a"}}, "`models.a.like: b` leads back to a; name another entry"),
        ({"a": {"like": "a"}}, "`models.a.like: a` leads back to a; name another entry"),
        ({"nets": NETS, "more": {"from": "nets", "suffix": "b"}}, "`models.more.from: nets` asks for a model for each"),
        ({"dnn": {**DNN, "reads": [{"trj": 0.1}]}}, r"`models.dnn.reads.0: trj` must be one of tri"),
        ({"dnn": {**DNN, "reads": ["parts", {"tri": -0.1}]}}, "`models.dnn.reads.1.tri: -0.1` must be above 0 and at"),
        ({"dnn": {**DNN, "reads": [{"tri": 0}]}}, r"`models.dnn.reads.0.tri: 0` must be above 0 and at most 1.0. Win"),
        ({"dnn": {**DNN, "reads": [{"tri": 16}]}}, "`models.dnn.reads.0.tri: 16` must be above 0 and at most 1"),
        ({"dnn": {**DNN, "reads": [{"tri": float("nan")}]}}, "`models.dnn.reads.0.tri: .nan` must be a number"),
        ({"dnn": {**DNN, "reads": [{"tri": "wide"}]}}, "`models.dnn.reads.0.tri: wide` must be a number, above 0 and"),
        ({"dnn": {**DNN, "reads": [{"tri": None}]}}, "`models.dnn.reads.0.tri` is empty and must be a number"),
        ({"dnn": {**DNN, "reads": [{"tri": 0.1, "parts": 0.1}]}},
         "`models.dnn.reads.0: .*` must be one input block with its window in seconds before and after a frame"),
        ({"dnn": {**DNN, "reads": [{}]}}, "`models.dnn.reads.0: .*` must be one input block with its window"),
        ({"dnn": {**DNN, "reads": ["tri", {"tri": 0.1}]}}, r"`models.dnn.reads: \[tri, tri\]` names tri more"),
        ({"dnn": {**DNN, "reads": {"tri": 0.1}}}, r"`models.dnn.reads: {tri: 0.1}` must be a list"),
        ({"hmm": {**HMM, "reads": [{"track": 0.1}]}}, "`models.hmm.reads` has a window; this family reads none."),
        ({"nets": {**NETS, "letters": ["FB", "BB"], "reads": [{"tri": 0.1}]}},
         "`models.nets.reads` has a window; a stack reads windows by a feed-forward layer. Begin `letters` with F"),
        ({"nets": {**NETS, "letters": ["B"]}, "more": {"like": "nets", "reads": [{"tri": 0.1}], "suffix": "b"}},
         "`models.more.reads` has a window; a stack"),
        ({"dnn": {**DNN, "layers": [6]}}, "`models.dnn.layers.0: 6` must be at least 1 and at most 5"),
        ({"dnn": {**DNN, "nodes": 5000}}, "`models.dnn.nodes: 5000` must be at least 1 and at most 4096"),
        ({"nets": {**NETS, "training": SHUFFLED}},
         "`models.nets.training.batcher: shuffled_frames` is for models that predict each frame by itself"),
        ({"dnn": {**DNN, "training": {**SHUFFLED, "objective": "sse_centred"}}},
         "`training.objective: sse_centred` must be one of sse, mse, ccc with `batcher: shuffled_frames`"),
        ({"dnn": {**DNN, "training": {**SHUFFLED, "open_weight": 1}}},
         "`training.open_weight: 1` must be 0 with `batcher: shuffled_frames`"),
    ],
)  # fmt: skip
def test_every_mistake_is_a_sentence(models, said):
    with pytest.raises(SettingError, match=said):
        rows(models)


@pytest.mark.parametrize("name", FAMILIES)
def test_every_family_is_what_its_entry_says(name):
    family = FAMILIES[name]
    if family.settings:
        assert issubclass(settings_class(family.settings), Settings)
        assert set(family.grid) <= set(settings_class(family.settings).__dataclass_fields__)
        assert not set(ENTRY_KEYS) & set(settings_class(family.settings).__dataclass_fields__)
    assert family.role in ROLES
    if family.module:
        module = importlib.import_module(family.module)
        assert name == module.FAMILY and callable(module.fit) and callable(module.restore)


def test_what_is_always_there_needs_no_settings():
    assert {entry["family"] for entry in ALWAYS.values()} <= set(FAMILIES)


def test_files_that_are_no_model(tmp_path):
    path = tmp_path / "model.safetensors"
    for family in ("forest", "reconstruction"):
        write_model(path, {}, {"kind": "model", "family": family})
        with pytest.raises(StorageError, match=f"unknown family '{family}'"):
            load_model(path)
    write_model(path, {}, {"kind": "block"})
    with pytest.raises(StorageError, match="model.safetensors: it holds no trained model"):
        load_model(path)


NEW_FAMILY = '''
"""The last training frame, whatever is said."""
from dataclasses import dataclass, field
import numpy as np
from visualspeech.models.block_states import BLOCK_ARRAYS, BLOCKS, pack, unpack
from visualspeech.models.task import Fitted, check_streams
from visualspeech.storage.layouts import Array, FileLayout
from visualspeech.storage.models import check_model, write_model

FAMILY = "last"

@dataclass(frozen=True)
class Last:
    frame: np.ndarray
    blocks: dict = field(default_factory=dict)
    rate: float = 25.0
    coding: str = ""

    @property
    def outputs(self):
        return len(self.frame)

    def predict(self, streams, frames, rate):
        check_streams(streams, self.blocks)
        return np.tile(self.frame, (frames, 1)).astype(np.float32)

    def save(self, path):
        arrays, blocks = pack(self.blocks)
        write_model(path, {"frame": self.frame, **arrays}, {"kind": "model", "family": FAMILY, "blocks": blocks})

def fit(task):
    import pandas
    return Fitted(Last(task.row.settings["factor"] * task.training[-1].target[-1], task.blocks), pandas.DataFrame())

LAYOUT = FileLayout({"frame": Array("f", ("N",)), **BLOCK_ARRAYS}, {"blocks": BLOCKS})

def restore(arrays, settings, path):
    check_model(arrays, settings, path, "last frame", ["model"], LAYOUT, FAMILY)
    return Last(arrays["frame"], unpack(arrays, settings["blocks"]))
'''
NEW_SETTINGS = '''
"""Settings of the last frame."""
from dataclasses import dataclass
from visualspeech.fields import Settings, setting

@dataclass(frozen=True)
class LastSettings(Settings):
    """Settings of the last frame."""
    section = "models"
    factor: float = setting(1.0, "Factor on the frame.", minimum=0, maximum=9)
'''


@pytest.fixture
def last(tmp_path, monkeypatch):
    """A new family: its modules beside the others, and one entry."""
    (tmp_path / "last.py").write_text(NEW_FAMILY)
    (tmp_path / "last_settings.py").write_text(NEW_SETTINGS)
    package = sys.modules["visualspeech.models"]
    monkeypatch.setattr(package, "__path__", [*package.__path__, str(tmp_path)])
    settings = "visualspeech.models.last_settings:LastSettings"
    monkeypatch.setitem(families.FAMILIES, "last", Family("visualspeech.models.last", settings, grid=("factor",),
                                                          cell=lambda given: f"last-{given['factor']:g}"))  # fmt: skip
    yield
    for name in ("visualspeech.models.last", "visualspeech.models.last_settings"):
        sys.modules.pop(name, None)


def test_a_new_family_is_a_module_and_an_entry(last, tmp_path):
    models = {"last": {"family": "last", "factor": [1, 2], "reads": ["tri"]}}
    assert names(models) == ["last-1", "last-2"]
    with pytest.raises(SettingError, match=r"unknown setting `models.last.facto`. Did you mean `factor`\?"):
        rows({"last": {**models["last"], "facto": 3}})
    with pytest.raises(SettingError, match="`models.last.factor: 10` must be at least 0 and at most 9"):
        rows({"last": {**models["last"], "factor": 10}})
    training = utterances(3)
    settings = row(models, "last-2").settings
    fitted = importlib.import_module(FAMILIES["last"].module).fit(task("last", settings, training))
    fitted.model.save(tmp_path / "model.safetensors")
    again = load_model(tmp_path / "model.safetensors")
    assert again.blocks == BLOCKS
    assert np.allclose(again.predict(training[0].streams, 3, 25.0), 2 * training[-1].target[-1])


def test_a_model_keeps_an_input_block_that_it_does_not_look_at(tmp_path):
    model = mean.fit(task("mean", training=utterances(2))).model
    model.save(tmp_path / "model.safetensors")
    assert load_model(tmp_path / "model.safetensors").blocks == BLOCKS
    assert Values(2).kind not in {block.kind for block in BLOCKS.values()}
