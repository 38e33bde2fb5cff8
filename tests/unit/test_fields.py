"""Settings classes: bounds, defaults and descriptions, written once, agree in the dataclass and in the schema."""

import copy
import re
import subprocess
import sys
from dataclasses import asdict, dataclass, fields, replace

import pytest

from tests.paths import REPOSITORY
from visualspeech.animation.rendering import RenderSettings
from visualspeech.animation.speaking_settings import SpeakSettings
from visualspeech.animation.video_settings import VideoSettings
from visualspeech.animation.walk import WalkSettings
from visualspeech.corpora.check_settings import CheckSettings
from visualspeech.corpora.demo.recording import DemoSettings
from visualspeech.corpora.motion_settings import MotionSettings
from visualspeech.errors import SettingError, StorageError
from visualspeech.evaluation.comparisons import ComparisonSettings
from visualspeech.evaluation.latex import LatexSettings
from visualspeech.evaluation.region_settings import EmotionSettings, RegionTableSettings
from visualspeech.evaluation.selection_settings import SelectionSettings
from visualspeech.evaluation.statistics import BootstrapSettings
from visualspeech.evaluation.tables import TableSettings
from visualspeech.evaluation.viseme_numbers import VisemeNumberSettings
from visualspeech.face.aam.fitting.model import FittingSettings
from visualspeech.face.aam.model import AamSettings
from visualspeech.face.aam.reference import ReferenceSettings
from visualspeech.face.drift import DriftSettings
from visualspeech.face.head import PoseSettings
from visualspeech.face.marker_coding import MarkerSettings
from visualspeech.face.screening import ScreeningSettings
from visualspeech.face.tracker import LandmarkSettings
from visualspeech.features.blocks.base import block_class, block_kinds
from visualspeech.features.blocks.dynamic_visemes import DynamicVisemesSettings
from visualspeech.features.blocks.full_context import FullContextSettings
from visualspeech.features.blocks.label_parts import LabelPartsSettings
from visualspeech.features.blocks.linguistic import LinguisticSettings
from visualspeech.features.blocks.log_mel import LogMelSettings
from visualspeech.features.blocks.phone import PhoneSettings
from visualspeech.features.blocks.phone_classes import PhoneClassesSettings
from visualspeech.features.blocks.phone_track import PhoneTrackSettings
from visualspeech.features.blocks.triphone_state import TriphoneStateSettings
from visualspeech.features.blocks.viseme_context import VisemeContextSettings
from visualspeech.features.speech_block import SpeechSettings
from visualspeech.fields import (
    MAX_SEED,
    FieldError,
    Settings,
    default_of,
    described_fields,
    restored,
    section_schema,
    setting,
    with_defaults,
)
from visualspeech.models.combined_settings import EnsembleSettings, GvCompensationSettings
from visualspeech.models.dnn_settings import DnnSettings
from visualspeech.models.families import FAMILIES
from visualspeech.models.hmm.model import HmmSettings
from visualspeech.models.joint_settings import JointSettings
from visualspeech.models.lookup_settings import LookupSettings
from visualspeech.models.stack_settings import MAX_LAYERS, StackSettings
from visualspeech.models.training_settings import TrainingSettings
from visualspeech.models.trajectory.settings import TrajectorySettings
from visualspeech.schema import check, settings_class
from visualspeech.speech.forced_alignment import AlignmentSettings
from visualspeech.speech.spoken_settings import VoiceSettings
from visualspeech.study.evaluation_settings import EvaluationSettings
from visualspeech.study.settings import StudySettings

CLASSES = [
    AamSettings, AlignmentSettings, BootstrapSettings, CheckSettings, ComparisonSettings, DemoSettings, DnnSettings,
    DriftSettings, DynamicVisemesSettings, EmotionSettings, EnsembleSettings, EvaluationSettings, FittingSettings,
    FullContextSettings,
    GvCompensationSettings, HmmSettings, JointSettings, LabelPartsSettings, LandmarkSettings, LinguisticSettings,
    LogMelSettings, LookupSettings, MarkerSettings, MotionSettings, PhoneClassesSettings, PhoneSettings,
    PhoneTrackSettings, PoseSettings, ReferenceSettings, RegionTableSettings, RenderSettings, ScreeningSettings,
    LatexSettings, SelectionSettings, SpeakSettings, SpeechSettings, StackSettings, StudySettings, TableSettings,
    TrainingSettings,
    TrajectorySettings, TriphoneStateSettings, VideoSettings, VisemeContextSettings, VisemeNumberSettings,
    VoiceSettings, WalkSettings,
]  # fmt: skip
HEAVY = {"av", "torch", "cv2", "dlib", "pandas", "scipy", "matplotlib", "h5py", "pocketsphinx", "jsonschema",
         "parselmouth", "opensmile"}  # fmt: skip
BESIDE = {"minimum": -1, "above": 0, "maximum": 1, "below": 0}  # how far outside a bound a value is


@dataclass(frozen=True)
class Inner(Settings):
    """What is inside."""

    section = "outer.inner"
    share: float = setting(0.5, "Share of something.", minimum=0, below=1)


@dataclass(frozen=True)
class Outer(Settings):
    """What is outside.

    More about it.
    """

    section = "outer"
    inner: Inner = setting(Inner(), "What is inside.")
    sizes: tuple[int, ...] = setting((2, 1), "Sizes.", item={"minimum": 1, "maximum": 9}, min_items=1, unique=True)
    words: tuple[str, ...] = setting((), "Words.", item={"choices": ("yes", "no")})
    name: str = setting("x", "Name.", min_length=1)
    code: str = setting("a1", "A small letter and a digit.", pattern="[a-z][0-9]")
    loud: bool = setting(False, "Whether it is loud.")
    hidden_from_users: int = 3


def accepted_by_schema(cls, name, value) -> bool:
    try:
        check({name: value}, section_schema(cls))
    except SettingError:
        return False
    return True


def accepted_by_class(cls, name, value) -> bool:
    try:
        cls(**{name: value})
    except SettingError as error:
        assert str(error).startswith(f"`{cls.section}.{name}: ") and str(error).endswith(".")
        return False
    return True


def wrong_values(kind, metadata):
    """Values on the wrong side of every rule of a field."""
    if kind in (int, float):
        yield from (True, "3", None, float("inf"), float("nan"))
    if kind is int:
        yield 2.5
    if kind is bool:
        yield from (1, "yes", None)
    if kind is str:
        yield from (1, None, False)
    if metadata["choices"]:
        yield "no such choice"
    if metadata.get("min_length"):
        yield ""
    if "pattern" in metadata:
        tried = ("", "?", "FBB\n", "a1 ", "a1a1")
        yield from (one for one in tried if not re.fullmatch(metadata["pattern"], one))
    for bound, step in BESIDE.items():
        if bound in metadata:
            yield metadata[bound] + step


@pytest.mark.parametrize("cls", [*CLASSES, Outer, Inner])
def test_defaults_satisfy_the_schema(cls):
    plain = with_defaults(cls, {})
    if cls is Outer:
        del plain["hidden_from_users"]
    check(plain, section_schema(cls))
    assert with_defaults(cls, plain) == with_defaults(cls, {})


def test_no_class_of_the_library_is_left_out():
    modules = {cls.__module__ for cls in CLASSES}
    found = set()
    for path in sorted((REPOSITORY / "visualspeech").rglob("*.py")):
        lines = path.read_text().splitlines()
        found |= {
            line.split("(")[0].removeprefix("class ") for line in lines if re.match(r"class \w+\(\w*Settings\):", line)
        }
    assert found == {cls.__name__ for cls in CLASSES} and len(modules) > 15
    families = {settings_class(family.settings) for family in FAMILIES.values() if family.settings}
    blocks = {block_class(kind).settings for kind in block_kinds()} - {None}
    assert families | blocks <= set(CLASSES)


@pytest.mark.parametrize("cls", CLASSES)
def test_every_field_is_described_and_every_number_bounded(cls):
    assert {name for name, *_ in described_fields(cls)} == {one.name for one in fields(cls)}
    assert cls.section
    for name, kind, metadata in described_fields(cls):
        description = metadata["description"]
        assert description.endswith(".") and description[0] in "ABCDEFGHIJKLMNOPQRSTUVWXYZ3", name
        if kind in (int, float):
            assert {"minimum", "above"} & set(metadata) and {"maximum", "below"} & set(metadata), name


@pytest.mark.parametrize("cls", [*CLASSES, Outer, Inner])
def test_class_and_schema_refuse_the_same(cls):
    for name, kind, metadata in described_fields(cls):
        for value in wrong_values(kind, metadata):
            assert not accepted_by_class(cls, name, value), (name, value)
            assert not accepted_by_schema(cls, name, value), (name, value)
        for bound in set(metadata) & {"minimum", "maximum"}:
            assert accepted_by_schema(cls, name, metadata[bound]), name
            # Two images are not enough for the components asked for, one BLSTM layer for the shared layers.
            if cls not in (AamSettings, JointSettings):
                assert accepted_by_class(cls, name, metadata[bound]), name


@pytest.mark.parametrize("cls", CLASSES)
def test_unknown_keys_are_refused(cls):
    with pytest.raises(SettingError, match="unknown setting `colour_of_hair`"):
        check({"colour_of_hair": 1}, section_schema(cls))
    with pytest.raises(SettingError, match=rf"unknown setting `{cls.section}.colour_of_hair`. Known here: "):
        with_defaults(cls, {"colour_of_hair": 1})


@pytest.mark.parametrize(
    "wrong",
    [
        {}, {"share": 1}, {"energy": 1}, {"energy": 0}, {"components": 0}, {"components": 2.0}, {"components": 100_001},
        {"energy": 0.9, "components": 3}, {"at_most": 3}, {"energy": 0.9, "at_most": 0},
        {"components": 3, "at_most": 9},
    ],
)  # fmt: skip
def test_components_of_an_analysis(wrong):
    assert not accepted_by_schema(AamSettings, "texture", wrong)
    with pytest.raises(SettingError, match="aam.texture"):
        AamSettings(texture=wrong)


@pytest.mark.parametrize(
    ("name", "wrong"),
    [
        ("sizes", []), ("sizes", [1, 1]), ("sizes", [0]), ("sizes", [10]), ("sizes", ["1"]), ("sizes", 3),
        ("words", ["maybe"]), ("words", "yes"), ("name", ""), ("inner", {"share": 1}), ("inner", 3), ("code", "11"),
    ],
)  # fmt: skip
def test_lists_and_nested_sections(name, wrong):
    assert not accepted_by_schema(Outer, name, wrong)
    with pytest.raises(SettingError, match=r"`outer\."):
        Outer(**{name: wrong})


def test_plain_data_builds_nested_settings():
    built = Outer(inner={"share": 0.25}, sizes=[4])
    assert built.inner == Inner(0.25) and built.sizes == (4,)
    assert with_defaults(Outer, {"inner": {}}, hidden=["loud", "hidden_from_users"]) == {
        "inner": {"share": 0.5}, "sizes": [2, 1], "words": [], "name": "x", "code": "a1",
    }  # fmt: skip
    with pytest.raises(SettingError, match=r"unknown setting `outer.inner.shar`"):
        Outer(inner={"shar": 1})


def test_a_message_says_value_rule_and_description():
    with pytest.raises(SettingError) as raised:
        Inner(1.0)
    assert str(raised.value) == "`outer.inner.share: 1.0` must be at least 0 and below 1. Share of something."
    with pytest.raises(SettingError, match="must be a finite number, at least 0 and below 1. Share of something."):
        Inner("0.5")


def test_a_message_says_the_place_in_the_settings_of_a_run():
    with pytest.raises(FieldError) as raised:
        with_defaults(Outer, {"inner": {"share": 2}}, where="systems.a.outer")
    assert str(raised.value).startswith("`systems.a.outer.inner.share: 2` must be at least 0 and below 1.")
    with pytest.raises(FieldError, match="^`outer.inner.share: 2` must be"):
        with_defaults(Outer, {"inner": {"share": 2}})
    with pytest.raises(FieldError, match="^`codings.x.aam.shape.components: 9` is more than there can be"):
        with_defaults(AamSettings, {"images": 2, "shape": {"components": 9}}, where="codings.x.aam")
    again = copy.copy(raised.value)  # as a pool of processes hands errors on
    assert str(again) == str(raised.value) and again.key == "systems.a.outer.inner.share"


def test_a_pattern_is_explained_by_the_description():
    with pytest.raises(SettingError) as raised:
        Outer(code="1a")
    assert str(raised.value) == "`outer.code: 1a` must be of this form: A small letter and a digit."
    with pytest.raises(SettingError) as raised:
        check({"code": "1a"}, section_schema(Outer), "here")
    assert str(raised.value) == "`here.code: 1a` must be of this form: A small letter and a digit."


def test_stacks_that_cannot_be():
    assert StackSettings("F" * MAX_LAYERS).letters and StackSettings("FB", 8, "layer").direction_nodes == 4
    for letters in ("F" * (MAX_LAYERS + 1), "", "fb", "FBB-128", "FXB"):
        with pytest.raises(SettingError, match=f"`models.letters: {letters}` must be of this form: Hidden layers"):
            StackSettings(letters)
    assert StackSettings("FF", 7, "layer").nodes == 7  # no B layer shares them
    with pytest.raises(SettingError, match="`models.nodes: 7` must be even: with `b_nodes: layer` .*; write 8. Width"):
        StackSettings("FB", 7, "layer")


def test_one_largest_seed():
    for cls in CLASSES:
        for name, _, metadata in described_fields(cls):
            assert name != "seed" or metadata["maximum"] == MAX_SEED, cls


def test_a_schema_has_the_first_line_the_defaults_and_no_hidden_field():
    schema = section_schema(Outer, hidden=["loud"])
    assert schema["description"] == "What is outside."
    assert set(schema["properties"]) == {"inner", "sizes", "words", "name", "code"}
    assert schema["properties"]["sizes"]["default"] == [2, 1]
    assert section_schema(Outer, "Another.")["description"] == "Another."


def test_a_default_is_never_shared():
    one = AamSettings()
    one.shape["energy"] = 0.5
    assert AamSettings().shape == {"energy": 0.99}
    assert all(default_of(field) is not None for field in fields(AamSettings))


def test_settings_of_another_version_are_refused():
    stored = asdict(replace(PoseSettings(), focal_length=2.0))
    assert restored(PoseSettings, stored, "head.safetensors").focal_length == 2.0
    with pytest.raises(StorageError, match="head.safetensors was written by another version .*`pose.focal`"):
        restored(PoseSettings, {"focal": 3.0}, "head.safetensors")


def test_unknown_bounds_are_mistakes_of_the_code():
    with pytest.raises(TypeError, match="minimun"):
        setting(1, "A number.", minimun=0)


def test_settings_are_imported_without_heavy_libraries():
    modules = ", ".join(sorted({cls.__module__ for cls in CLASSES}))
    code = f"import sys, {modules}; print(*({HEAVY!r} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], cwd=REPOSITORY, capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


@pytest.mark.parametrize(
    ("seconds", "frames"),
    [
        (PoseSettings().rotation_smoothing, 2.0), (PoseSettings().translation_smoothing, 0.5),
        (LandmarkSettings().smoothing, 0.4), (RenderSettings().point_smoothing, 1.0),
        (RenderSettings().colour_smoothing, 2.0), (WalkSettings().crossfade, 6.0),
        (LandmarkSettings().detection_interval, 25.0), (DriftSettings().min_silent_seconds, 5.0),
    ],
)  # fmt: skip
def test_times_are_exact_numbers_of_frames_at_25_hz(seconds, frames):
    """Figures measured at 25 Hz were measured with these numbers of frames, to the last bit."""
    assert seconds * 25.0 == frames
