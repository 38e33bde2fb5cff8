"""The phones that a model knows, and what it predicts from new speech, for every family."""

import numpy as np
import pytest

from tests.unit.models.examples import task
from tests.unit.speech.alignments import even_alignment
from visualspeech.errors import DataError
from visualspeech.features.blocks.base import Source
from visualspeech.features.blocks.label_parts import LabelParts
from visualspeech.features.blocks.phone_track import PhoneTrack
from visualspeech.features.blocks.triphone_state import TriphoneState
from visualspeech.features.examples import Example
from visualspeech.models import dnn, ensemble, gv_compensation, joint, lookup, mean, stack
from visualspeech.models.families import FAMILIES
from visualspeech.models.hmm import family as hmm
from visualspeech.models.inventory import phones_of, predict_alignment
from visualspeech.models.registry import load_model

PHONES = ("sil", "ae", "m", "p")
ALIGNMENT = even_alignment([("sil", ["sil"]), ("map", ["m", "ae", "p"]), ("sil", ["sil"])], 0.2)
TRI, TRACK, PARTS = TriphoneState(PHONES), PhoneTrack(PHONES), LabelParts(("position_in_word",))
CASES = {
    "stack": (stack, {"letters": "F", "nodes": 4}, {"parts": PARTS, "tri": TRI}, {"max_epochs": 1}),
    "hmm": (hmm, {"variant": "monophone", "states": 2, "rate": 50.0}, {"track": TRACK}, {}),
    "lookup": (lookup, {}, {"tri": TRI}, {}),
    "mean": (mean, {}, {}, {}),
    "dnn": (dnn, {"layers": 1, "nodes": 4}, {"tri": TRI}, {"max_epochs": 1}),
    "joint": (joint, {"nodes": 4}, {"tri": TRI}, {"max_epochs": 1, "batcher": "frames"}),
    "ensemble": (ensemble, {"members": ["hmm", "lookup"]}, {"track": TRACK, "tri": TRI}, {}),
    "gv_compensation": (gv_compensation, {}, {"tri": TRI}, {}),
}
#: Families of the models that one of a family is made of.
PARENTS = {"ensemble": ["hmm", "lookup"], "gv_compensation": ["lookup"]}
#: Columns of the parameters by region of the face.
REGIONS = {"joint": {"upper": (0,), "lower": (1, 2)}}


def examples(blocks):
    frames, rate = 25, 25.0
    source = Source(frames, rate, ALIGNMENT)
    streams = tuple(next(iter(block.encode([source]))) for block in blocks.values())
    target = np.random.default_rng(0).normal(size=(frames, 3)).astype(np.float32)
    return [Example(streams, target, rate)] * 3


@pytest.fixture(params=CASES)
def model(request, tmp_path):
    return fitted(request.param, tmp_path)


def fitted(family, folder):
    module, settings, blocks, options = CASES[family]
    paths = [folder / f"{name}.safetensors" for name in PARENTS.get(family, [])]
    for name, path in zip(PARENTS.get(family, []), paths, strict=True):
        fitted(name, folder).save(path)
    given = examples(blocks)
    regions = REGIONS.get(family, {})
    return module.fit(task(family, settings, given, given, blocks, options, parents=paths, regions=regions)).model


def test_all_families_are_here():
    assert set(CASES) == {name for name, family in FAMILIES.items() if family.module}


def test_new_speech_goes_through_the_blocks_of_the_model(model, tmp_path):
    found = predict_alignment(model, ALIGNMENT, 25)
    (streams, *_), *_ = examples(model.blocks)
    assert found.shape == (25, 3) and found.dtype == np.float32
    assert np.array_equal(found, model.predict(streams, 25, 25.0))
    model.save(tmp_path / "model.safetensors")
    assert np.array_equal(predict_alignment(load_model(tmp_path / "model.safetensors"), ALIGNMENT, 25), found)
    assert predict_alignment(model, ALIGNMENT, 40).shape == (40, 3)


def test_the_phones_of_a_model(model):
    assert phones_of(model) == (PHONES if model.blocks else ())


def test_phones_that_a_model_does_not_know_are_named(model):
    other = even_alignment([("zoo", ["z", "uw"])])
    if model.blocks:
        with pytest.raises(DataError, match="inventory of 4 phones does not have uw, z"):
            predict_alignment(model, other, 5)
    else:
        assert predict_alignment(model, other, 5).shape == (5, 3)
