"""Settings: layers, and sentences instead of tracebacks for what is mistyped."""

import pytest
import yaml
from visualspeech.models.baselines import BaselineSettings

from tests.paths import REPOSITORY
from visualspeech.corpora.check_settings import CheckSettings
from visualspeech.errors import SettingError
from visualspeech.face.aam.model import AamSettings
from visualspeech.face.aam.reference import ReferenceSettings
from visualspeech.face.drift import DriftSettings
from visualspeech.face.head import PoseSettings
from visualspeech.face.screening import ScreeningSettings
from visualspeech.face.tracker import LandmarkSettings
from visualspeech.features.streams import FeatureSettings
from visualspeech.models.training import TrainingSettings
from visualspeech.schema import load_schema
from visualspeech.settings import merged, model_names, resolve
from visualspeech.speech.forced_alignment import AlignmentSettings

CONFIG = REPOSITORY / "config"
SECTIONS = {
    "check": CheckSettings,
    "alignment": AlignmentSettings,
    "landmarks": LandmarkSettings,
    "screening": ScreeningSettings,
    "pose": PoseSettings,
    "texture": ReferenceSettings,
    "drift": DriftSettings,
    "aam": AamSettings,
    "features": FeatureSettings,
    "baselines": BaselineSettings,
    "training": TrainingSettings,
}


def default():
    return yaml.safe_load((CONFIG / "config.yaml").read_text())


@pytest.fixture(scope="module")
def schema():
    return load_schema(REPOSITORY / "workflow" / "schemas" / "config.schema.yaml")


def test_every_key_is_described(schema):
    def undescribed(node, path):
        for key, value in node.get("properties", {}).items():
            if "description" not in value:
                yield f"{path}{key}"
            yield from undescribed(value, f"{path}{key}.")

    assert list(undescribed(schema, "")) == []


@pytest.mark.parametrize("overlay", sorted(CONFIG.glob("*.yaml")), ids=lambda path: path.name)
def test_every_shipped_config_builds_its_settings(overlay):
    settings = resolve(merged(default(), yaml.safe_load(overlay.read_text())), CONFIG)
    for section, cls in SECTIONS.items():
        cls(**settings[section])
    assert model_names(settings)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"aam": {"shap": {"energy": 0.9}}}, r"unknown setting `aam\.shap`\. Did you mean `shape`\?"),
        ({"sed": 3}, r"unknown setting `sed`\. Did you mean `seed`\?"),
        ({"shards": "four"}, r"`shards: four`"),
        ({"networks": {"stacks": ["FXB"]}}, r"`networks\.stacks\.0: FXB`"),
        ({"networks": {"nodes": [0]}}, r"`networks\.nodes\.0: 0`"),
        ({"tables": {"metrics": ["rmse"]}}, r"rmse.* must be one of rmse_shape"),
        ({"corpus": "demmo"}, r"`corpus: demmo` is not known.*Did you mean `demo`"),
        ({"experiment": "fan2016"}, r"`experiment: fan2016` is not known.*Did you mean `fan2015`"),
        ({"split": {"train": 0.9}}, r"must sum to 1"),
        ({"videos": {"model": "BBB-512"}}, r"`videos\.model: BBB-512` is not trained\. Trained here: FFF-64.*FBB-128"),
        ({"corpus": {"name": "mine"}}, r"`corpus` lacks `adapter`"),
        ({"aam": {"shape": {"energy": 0.9, "components": 3}}}, r"aam\.shape"),
        ({"aam": {"shape": {"energy": 1.5}}}, r"aam\.shape\.energy: 1\.5"),
    ],
)
def test_mistakes_are_named(change, said):
    with pytest.raises(SettingError, match=said):
        resolve(merged(default(), change), CONFIG)


def test_merging_leaves_its_inputs_alone():
    base, over = {"a": {"b": 1, "c": [1]}, "d": 2}, {"a": {"c": [2]}, "d": {"e": 3}}
    result = merged(base, over)
    assert result == {"a": {"b": 1, "c": [2]}, "d": {"e": 3}}
    result["a"]["c"].append(9)
    assert (base, over) == ({"a": {"b": 1, "c": [1]}, "d": 2}, {"a": {"c": [2]}, "d": {"e": 3}})


def test_components_take_the_place_of_an_energy():
    base = {"shape": {"energy": 0.9, "at_most": 5}}
    assert merged(base, {"shape": {"components": 3}}) == {"shape": {"components": 3}}
    assert merged({"shape": {"components": 3}}, base) == base
    assert merged(base, {"shape": {"energy": 0.8}}) == {"shape": {"energy": 0.8, "at_most": 5}}


def test_a_corpus_file_anywhere_names_its_root_from_its_own_folder(tmp_path):
    (tmp_path / "mine.yaml").write_text("name: mine\nadapter: folder\nroot: clips\n")
    settings = resolve(merged(default(), {"corpus": str(tmp_path / "mine.yaml")}), CONFIG)
    assert settings["corpus"]["root"] == str(tmp_path / "clips")


def test_a_corpus_may_be_given_in_place():
    corpus = {"name": "mine", "adapter": "folder", "root": "/somewhere"}
    assert resolve(merged(default(), {"corpus": corpus}), CONFIG)["corpus"] == corpus


def with_networks(**changes):
    return resolve(merged(default(), {"networks": changes}), CONFIG)


def test_further_seeds_and_richer_labels_have_names_of_their_own():
    settings = with_networks(stacks=["FBB", "F"], nodes=[128], seeds=[1, 5])
    assert model_names(settings) == ["FBB-128", "F-128", "FBB-128-s5", "F-128-s5"]
    richer = merged(settings, {"networks": {"seeds": [3], "richer": ["FBB-128"]}})
    assert model_names(richer) == ["FBB-128", "F-128", "FBB-128-rich"]


def test_networks_that_cannot_be_are_named_before_any_job():
    with pytest.raises(SettingError, match="networks.label_parts.0: tone` must be one of position_in_syllable"):
        with_networks(richer=["FBB-128"], label_parts=["tone"])
    with pytest.raises(SettingError, match="`networks.nodes: 129` is odd"):
        with_networks(nodes=[128, 129], b_nodes="layer")
    with pytest.raises(SettingError, match="networks.b_nodes: both` must be one of direction, layer"):
        with_networks(b_nodes="both")
