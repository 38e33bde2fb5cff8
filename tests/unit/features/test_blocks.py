"""Input blocks: what each kind reads of an alignment, through its file, and a new kind that is only a module."""

import sys
from dataclasses import replace

import numpy as np
import pytest

from tests.unit.speech.alignments import even_alignment
from visualspeech.errors import DataError, SettingError, StorageError
from visualspeech.features.blocks import base
from visualspeech.features.blocks.base import (
    Source,
    block_class,
    block_kinds,
    block_module,
    encoding_needs,
    fit_block,
    load_block,
    needs_of,
    save_block,
    unavailable,
)
from visualspeech.features.contexts import phone_contexts, phone_inventory
from visualspeech.features.label_parts import PARTS, label_parts
from visualspeech.features.labels import label_indices, label_shares, one_hot
from visualspeech.features.streams import check_stream
from visualspeech.fields import Settings, with_defaults
from visualspeech.models.block_states import load_blocks, pack, unpack
from visualspeech.speech import tts
from visualspeech.speech.alignment import to_table
from visualspeech.speech.phone_classes import PHONE_CLASSES
from visualspeech.speech.sound import Sound
from visualspeech.storage.arrays import ArrayReader, ArrayWriter
from visualspeech.storage.models import write_model
from visualspeech.storage.tables import write_table

SENTENCES = (
    [("sil", ["sil"]), ("computer", "k ah m p y uw t er".split()), ("a", ["ah"]), ("sil", ["sil"])],
    [("sil", ["sil"]), ("map", ["m", "ae", "p"]), ("sil", ["sil"])],
)
LENGTHS = (28, 13)
SOURCES = [Source(frames, 25.0, even_alignment(words)) for frames, words in zip(LENGTHS, SENTENCES, strict=True)]
NOISE = np.random.default_rng(5).normal(0, 2000, (2, 18000)).astype(np.int16)
FACES = np.random.default_rng(6).normal(0, 10, (2, 28, 3)).cumsum(axis=1)
#: With all that a block can be computed from.
HEARD = [
    replace(one, sound=Sound(noise[: 640 * one.frames]), parameters=face[: one.frames], id=name)
    for one, noise, face, name in zip(SOURCES, NOISE, FACES, "ab", strict=True)
]
PHONES = phone_inventory(source.alignment for source in SOURCES)


#: Kinds that can be computed with what is installed.
COMPUTED = [kind for kind in block_kinds() if not unavailable(block_class(kind))]


def fitted(kind, **settings):
    cls = block_class(kind)
    if kind == "dynamic_visemes":
        settings = {"classes": 3, **settings}
    blocks = {}
    if kind == "viseme_context":
        blocks = {"dv": fitted("dynamic_visemes", source=settings.pop("source", "predicted"))}
        settings = {"visemes": "dv", **settings}
    return fit_block(kind, with_defaults(cls.settings, settings) if cls.settings else {}, PHONES, iter(HEARD), blocks)


def test_the_kinds_are_the_modules():
    assert block_kinds() == [
        "arrays",
        "dynamic_visemes",
        "full_context",
        "label_parts",
        "linguistic",
        "log_mel",
        "phone",
        "phone_classes",
        "phone_track",
        "speech27",
        "speech44",
        "triphone_state",
        "viseme_context",
    ]
    for kind in block_kinds():
        cls = block_class(kind)
        assert cls.kind == kind and cls.__module__ == block_module(kind)
        assert cls.settings is None or issubclass(cls.settings, Settings)
    known = "arrays, dynamic_visemes, full_context, label_parts, linguistic, log_mel, phone, phone_classes, phone_track"
    with pytest.raises(StorageError, match=f"kind 'triphones' is unknown. Known: {known}"):
        block_class("triphones")


@pytest.mark.parametrize(
    ("kind", "settings"),
    [
        *((kind, {}) for kind in COMPUTED),
        ("triphone_state", {"fractional": True}),
        ("triphone_state", {"states": "thirds"}),
        ("phone_classes", {"fractional": True, "states": "thirds"}),
        ("phone_classes", {"states": "none"}),
        ("phone_track", {"states": "aligned"}),
        ("phone", {"long_pause": 0.05}),
        ("linguistic", {"features": ["phone_context", "position"]}),
        ("linguistic", {"features": ["acoustic_class"], "long_pause": 1.0}),
        ("dynamic_visemes", {"source": "oracle"}),
        ("viseme_context", {"source": "oracle"}),
        ("viseme_context", {"features": ["viseme_context", "position"]}),
        ("viseme_context", {"features": ["number_of_frames"]}),
    ],
)
def test_streams_fit_the_layout_and_the_file_gives_the_same(tmp_path, kind, settings):
    block = fitted(kind, **settings)
    save_block(tmp_path / "block.safetensors", block)
    again = load_block(tmp_path / "block.safetensors")
    assert again == block and again.layout == block.layout
    streams = list(block.encode(HEARD))
    assert len(streams) == len(HEARD)
    for stream, other, source in zip(streams, again.encode(HEARD), HEARD, strict=True):
        check_stream(stream, block.layout, kind)
        assert block.layout.segmental or len(stream) == source.frames
        assert stream.arrays().keys() == other.arrays().keys()
        assert all(np.array_equal(values, other.arrays()[name]) for name, values in stream.arrays().items())


def test_triphone_state_is_the_vector_of_the_paper():
    block = fitted("triphone_state")
    assert block.layout.sizes == (len(PHONES),) * 3 + (3,) and block.layout.width == 3 * len(PHONES) + 3
    for stream, source in zip(block.encode(SOURCES), SOURCES, strict=True):
        labels = label_indices(source.alignment, source.frames, source.rate, PHONES)
        assert np.array_equal(stream.index, labels)
        parts = np.split(one_hot(labels, len(PHONES)), np.cumsum(block.layout.sizes)[:-1], axis=1)
        assert all(np.array_equal(part.argmax(axis=1), stream.index[:, n]) for n, part in enumerate(parts))


def test_phone_track_has_the_starts_of_the_phones():
    for stream, source in zip(fitted("phone_track").encode(SOURCES), SOURCES, strict=True):
        assert np.array_equal(stream.index, phone_contexts(source.alignment, PHONES))
        assert stream.starts.tolist() == [phone.start for phone in source.alignment.phones]


def test_phone_track_can_have_the_starts_of_the_states():
    for stream, source in zip(fitted("phone_track", states="aligned").encode(SOURCES), SOURCES, strict=True):
        phones, states = source.alignment.phones, source.alignment.states
        assert np.array_equal(stream.index[:, :3], np.repeat(phone_contexts(source.alignment, PHONES), 3, axis=0))
        assert stream.index[:, 3].tolist() == [0, 1, 2] * len(phones)
        assert stream.starts.tolist() == [state.start for state in states]


def test_triphone_state_as_shares_of_the_frame():
    block, source = fitted("triphone_state", fractional=True), SOURCES[0]
    classes = fitted("triphone_state").layout
    assert (block.layout.sizes, block.layout.dimension) == ((), classes.width)
    stream = next(block.encode([source]))
    expected = label_shares(source.alignment, source.frames, source.rate, PHONES)
    assert stream.index is None and np.array_equal(stream.values, expected)
    thirds = next(fitted("triphone_state", fractional=True, states="thirds").encode([source]))
    assert np.allclose(thirds.values, expected, atol=1e-5)  # the states of these utterances are even


@pytest.mark.parametrize("fractional", [False, True])
def test_phone_classes_are_those_of_the_three_phones(fractional):
    """Classes are a linear map of labels: memberships weighted by the shares of the phones."""
    block = fitted("phone_classes", fractional=fractional)
    members = np.array([[phone in one for one in PHONE_CLASSES.values()] for phone in PHONES], float)
    for stream, source in zip(block.encode(SOURCES), SOURCES, strict=True):
        asked = source.alignment, source.frames, source.rate, PHONES
        labels = label_shares(*asked) if fractional else one_hot(label_indices(*asked), len(PHONES))
        *phones, states = np.split(labels, len(PHONES) * np.arange(1, 4), axis=1)
        expected = np.concatenate([*(part @ members for part in phones), states], axis=1)
        assert np.allclose(stream.values, expected, atol=1e-5)
    without = fitted("phone_classes", fractional=fractional, states="none")
    assert without.layout.dimension == block.layout.dimension - 3
    assert np.array_equal(next(without.encode(SOURCES[:1])).values, next(block.encode(SOURCES[:1])).values[:, :-3])


def test_phone_classes_need_no_inventory():
    cls = block_class("phone_classes")
    block = cls.fit(with_defaults(cls.settings, {}), PHONES[:2], ())
    assert np.array_equal(*(next(one.encode(SOURCES[:1])).values for one in (block, fitted("phone_classes"))))
    columns = list(PHONE_CLASSES)
    values = next(block.encode(SOURCES[1:])).values[:, len(columns) : 2 * len(columns)]
    frame = 3  # 0.14 s: the m of "map"
    assert {name for name, value in zip(columns, values[frame], strict=True) if value} == {
        "nasal", "bilabial", "sonorant", "labial", "consonant", "voiced",
    }  # fmt: skip


def test_label_parts_are_those_that_the_settings_name():
    block = fitted("label_parts", parts=["position_in_word", "stress"])
    assert block.layout.sizes == tuple(len(PARTS[part]) for part in block.parts)
    for stream, source in zip(block.encode(SOURCES), SOURCES, strict=True):
        expected = label_parts(source.alignment, source.frames, source.rate, block.parts)
        assert np.array_equal(stream.index, expected)
    assert fitted("label_parts").parts == tuple(PARTS)
    with pytest.raises(SettingError, match="blocks.parts"):
        fitted("label_parts", parts=["tone"])


def test_the_synthesiser_is_asked_once_and_for_stress_alone(monkeypatch):
    asked = []
    monkeypatch.setattr(tts, "stresses", lambda words: asked.append(list(words)) or {})
    list(fitted("label_parts").encode(SOURCES))
    list(fitted("label_parts", parts=["position_in_word"]).encode(SOURCES))
    assert asked == [["a", "computer", "map"]]


def test_phones_of_another_corpus_are_named():
    for kind in ("triphone_state", "phone_track"):
        cls = block_class(kind)
        block = cls.fit(with_defaults(cls.settings, {}), PHONES[:3], iter(()))
        with pytest.raises(DataError, match="the inventory of 3 phones does not have"):
            list(block.encode(SOURCES))


@pytest.mark.parametrize("state", [{}, {"phones": 3}, {"sounds": ["a"]}])
def test_states_that_are_no_states_are_a_sentence(tmp_path, state):
    path = tmp_path / "block.safetensors"
    write_model(path, {}, {"kind": "block", "block": "triphone_state", "state": state})
    with pytest.raises(StorageError, match="block.safetensors: (`phones` in )?its settings"):
        load_block(path)
    write_model(path, {}, {"kind": "block", "block": "triphone", "state": state})
    with pytest.raises(StorageError, match="'triphone' is unknown"):
        load_block(path)


def test_what_blocks_are_computed_from(tmp_path):
    write_table(
        tmp_path / "alignment.tsv",
        to_table({name: SOURCES[number].alignment for name, number in (("a", 0), ("b", 1), ("c", 0))}),
    )
    with ArrayWriter(tmp_path / "targets.h5") as out:
        out.add("a", {"appearance": np.zeros((28, 2))}, rate=25.0)
        out.add("c", {"appearance": np.zeros((56, 2))}, rate=50.0)
    with ArrayReader(tmp_path / "targets.h5") as targets:
        # Utterance b is accepted but has no targets; c has some and is not accepted.
        assert base.read_sources(tmp_path / "alignment.tsv", targets, ["a", "b"]) == {"a": replace(SOURCES[0], id="a")}
        known = [phone for phone in PHONES if phone != "ah"]
        (other,) = base.read_sources(tmp_path / "alignment.tsv", targets, ["a"], known).values()
        assert {one.label for one in other.alignment.phones} <= set(known)
        found = base.read_sources(tmp_path / "alignment.tsv", targets, ["c"])["c"]
    assert (found.frames, found.rate) == (56, 50.0)


def test_blocks_say_what_they_are_computed_from():
    needs = {kind: needs_of(block_class(kind)) for kind in block_kinds()}
    assert needs.pop("log_mel") == needs.pop("speech27") == needs.pop("speech44") == ("audio",)
    assert needs.pop("dynamic_visemes") == needs.pop("viseme_context") == ("text", "faces")
    assert needs.pop("arrays") == ()
    assert set(needs.values()) == {("text",)}
    # What a label block reads does not change where there is sound.
    for kind in needs:
        for one, other in zip(fitted(kind).encode(SOURCES), fitted(kind).encode(HEARD), strict=True):
            assert all(np.array_equal(values, other.arrays()[name]) for name, values in one.arrays().items())


def test_sound_is_read_when_a_block_asks_for_it(tmp_path):
    with ArrayWriter(tmp_path / "audio.h5") as out:
        for name, samples in zip("ab", NOISE, strict=True):
            out.add(name, {"samples": samples}, rate=16000)
    with ArrayWriter(tmp_path / "targets.h5") as out:
        out.add("a", {"appearance": np.zeros((28, 2))}, rate=25.0)
        out.add("c", {"appearance": np.zeros((28, 2))}, rate=25.0)
    with ArrayReader(tmp_path / "targets.h5") as targets, ArrayReader(tmp_path / "audio.h5") as audio:
        found = base.read_sources(None, targets, ["a", "b", "c"], audio=audio)
        assert list(found) == ["a"] and found["a"].alignment is None  # b has no targets, c no sound
        sound = found["a"].sound
        assert (len(sound.samples), sound.rate) == (18000, 16000)
        assert np.array_equal(sound.between(7, 12), NOISE[0, 7:12] / 32768)
        block = fitted("log_mel")
        (stream,) = block.encode([found["a"]])
        (other,) = block.encode([replace(SOURCES[0], sound=Sound(NOISE[0]))])
        assert np.array_equal(stream.values, other.values)
        # A block that must have all of them fails where one is missing, and does not leave it out.
        with pytest.raises(StorageError, match="audio.h5.*'c'"):
            list(block.encode(list(base.read_sources(None, targets, ["a", "c"], complete=True, audio=audio).values())))


def test_blocks_inside_a_model():
    blocks = {"parts": fitted("label_parts", parts=["stress"]), "tri": fitted("triphone_state")}
    arrays, plain = pack(blocks)
    assert [(entry["name"], entry["kind"]) for entry in plain] == [("parts", "label_parts"), ("tri", "triphone_state")]
    again = unpack(arrays, plain)
    assert again == blocks and list(again) == list(blocks)
    assert pack({}) == ({}, []) and unpack({}, []) == {}
    with pytest.raises(StorageError, match="'tri' is unknown"):
        unpack({}, [{"name": "tri", "kind": "tri", "state": {}}])


def test_blocks_by_name_from_their_files(tmp_path):
    blocks = {"a": fitted("phone_track"), "b": fitted("triphone_state")}
    for name, block in blocks.items():
        save_block(tmp_path / name, block)
    assert load_blocks({name: tmp_path / name for name in blocks}) == blocks
    write_model(tmp_path / "a", {}, {"kind": "model", "family": "mean"})
    with pytest.raises(StorageError, match="a: it holds no input block"):
        load_blocks({"a": tmp_path / "a"})


NEW_KIND = '''
"""Loudness of every frame, made up from its number."""
from dataclasses import dataclass, field
from typing import ClassVar
import numpy as np
from visualspeech.features.streams import Layout, Stream
from visualspeech.fields import Settings, setting
from visualspeech.storage.layouts import Array, FileLayout

@dataclass(frozen=True)
class LoudnessSettings(Settings):
    """Settings of the block ``loudness``."""
    section: ClassVar[str] = "blocks"
    gain: float = setting(2.0, "Factor.", minimum=0, maximum=9)

@dataclass(frozen=True)
class Loudness:
    """One value a frame, less the mean of training."""
    kind: ClassVar[str] = "loudness"
    settings: ClassVar[type | None] = LoudnessSettings
    stored: ClassVar[FileLayout] = FileLayout({"mean": Array("f", (1,))}, {"gain": {"type": "number"}})
    gain: float
    mean: np.ndarray = field(compare=False)

    @classmethod
    def fit(cls, settings, phones, training):
        return cls(settings["gain"], np.array([float(np.mean([one.frames for one in training]))]))

    @property
    def layout(self):
        return Layout(dimension=1)

    def encode(self, sources):
        for one in sources:
            yield Stream(values=(self.gain * np.arange(one.frames)[:, None] - self.mean).astype(np.float32))

    def state(self):
        return {"mean": self.mean}, {"gain": self.gain}

    @classmethod
    def restore(cls, arrays, plain):
        return cls(plain["gain"], arrays["mean"])

BLOCK = Loudness
'''


@pytest.fixture
def loudness(tmp_path, monkeypatch):
    """A new kind of block: a module beside the others, and nothing else."""
    (tmp_path / "loudness.py").write_text(NEW_KIND)
    package = sys.modules["visualspeech.features.blocks"]
    monkeypatch.setattr(package, "__path__", [*package.__path__, str(tmp_path)])
    yield
    sys.modules.pop("visualspeech.features.blocks.loudness", None)


def test_a_new_kind_is_a_module_beside_the_others(loudness, tmp_path):
    assert "loudness" in block_kinds()
    cls = block_class("loudness")
    block = cls.fit(with_defaults(cls.settings, {"gain": 3}), PHONES, iter(SOURCES))
    assert block.mean.tolist() == [20.5]
    for stream, source in zip(block.encode(SOURCES), SOURCES, strict=True):
        check_stream(stream, block.layout, "loudness")
        assert len(stream) == source.frames
    save_block(tmp_path / "block.safetensors", block)
    again = load_block(tmp_path / "block.safetensors")
    assert again == block and np.array_equal(again.mean, block.mean)
    both = {"tri": fitted("triphone_state"), "loud": replace(block, gain=1.0)}
    found = unpack(*pack(both))
    assert found["loud"].mean.tolist() == [20.5] and found["tri"] == both["tri"]


def test_visemes_of_new_speech_need_its_text_alone():
    for kind in ("dynamic_visemes", "viseme_context"):
        predicted, oracle = fitted(kind), fitted(kind, source="oracle")
        assert encoding_needs(predicted) == ("text",) and "faces" in encoding_needs(oracle)
        # What is not of the training, nor has a face, is read by the model of all training utterances.
        for stream, source in zip(predicted.encode(SOURCES), SOURCES, strict=True):
            assert len(stream) == source.frames
        with pytest.raises(DataError, match=r"`source: oracle`\), and new speech has none"):
            list(oracle.encode(SOURCES))


@pytest.mark.parametrize("kind", ["dynamic_visemes", "viseme_context"])
def test_a_model_keeps_no_trace_of_which_utterances_it_was_trained_on(kind):
    block = fitted(kind)
    arrays, plain = pack({"dv": block})
    assert any("crossfit" in name for name in block.state()[0]) and not any("crossfit" in name for name in arrays)
    (again,) = unpack(arrays, plain).values()
    assert again == block.for_new_speech() != block and again.for_new_speech() == again
    for one, other in zip(again.encode(SOURCES), block.encode(SOURCES), strict=True):
        assert all(np.array_equal(values, other.arrays()[name]) for name, values in one.arrays().items())


def test_recorded_parameters_are_read_when_a_block_asks_for_them(tmp_path):
    with ArrayWriter(tmp_path / "targets.h5") as out:
        for name, face in zip("ab", FACES, strict=True):
            out.add(name, {"appearance": face}, rate=25.0)
    with ArrayReader(tmp_path / "targets.h5") as targets:
        found = base.read_sources(None, targets, ["a", "b"], faces=True)
        assert base.read_sources(None, targets, ["a"])["a"].parameters is None
        assert np.array_equal(np.asarray(found["b"].parameters), FACES[1]) and found["b"].id == "b"
        sources = base.Sources([], targets, ["a"], faces=True)
        assert [one.id for one in sources] == [one.id for one in sources] == ["a"]  # any number of passes


def test_blocks_of_a_model_have_the_same_phones():
    arrays, plain = pack(
        {"tri": fitted("triphone_state"), "track": fitted("phone_track"), "ph": fitted("phone_classes")}
    )
    assert list(unpack(arrays, plain)) == ["tri", "track", "ph"]
    plain[1]["state"]["phones"] = plain[1]["state"]["phones"][:-1]
    with pytest.raises(StorageError, match="its input blocks have different phones"):
        unpack(arrays, plain)
