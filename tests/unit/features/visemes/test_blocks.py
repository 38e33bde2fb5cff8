"""Blocks of dynamic visemes: what they learn from, what they keep, and files of them that were altered."""

import copy
import warnings
from dataclasses import replace

import numpy as np
import pytest

from tests.alterations import alter_arrays, alter_plain
from tests.unit.features.visemes.speakers import PHONES, RATE, corpus
from visualspeech.errors import DamagedFile, DataError, VisualSpeechError
from visualspeech.features.blocks.base import load_block, save_block
from visualspeech.features.blocks.dynamic_visemes import DynamicVisemes
from visualspeech.features.blocks.viseme_context import VisemeContext
from visualspeech.features.streams import check_stream
from visualspeech.features.unit_contexts import NO_POSITION, POSITIONS
from visualspeech.features.visemes.segmentation import gestures_of
from visualspeech.fields import with_defaults
from visualspeech.speech.structure import structure_of
from visualspeech.storage.models import read_model, write_model

TRAINING, TEST = corpus(12), corpus(3, seed=9)


def fitted(training=TRAINING, **settings):
    given = {"classes": 8, "folds": 3, **settings}
    return DynamicVisemes.fit(with_defaults(DynamicVisemes.settings, given), PHONES, training)


def context_of(visemes, training=TRAINING, **settings):
    given = with_defaults(VisemeContext.settings, {"visemes": "dv", **settings})
    return VisemeContext.fit(given, PHONES, training, {"dv": visemes})


PREDICTED, ORACLE = fitted(), fitted(source="oracle")
CONTEXT = context_of(PREDICTED)


def test_oracle_visemes_are_those_of_the_recording():
    one = TEST[0]
    (stream,) = ORACLE.encode([one])
    gestures = gestures_of(one.parameters, RATE, 0.04, 0.06)
    assert np.array_equal(stream.index[:, 0], ORACLE.classes.assign(one.parameters, gestures)[gestures.of_frames()])
    assert ORACLE.text is None and ORACLE.layout.sizes == (8,)


def test_both_sources_have_the_same_classes_and_the_fit_is_repeatable():
    assert np.array_equal(PREDICTED.classes.means, ORACLE.classes.means) and PREDICTED != ORACLE
    assert fitted() == PREDICTED and fitted(seed=2) != PREDICTED
    assert fitted(iter(TRAINING)) == PREDICTED  # an iterator, which can be gone through once


def test_predicted_visemes_do_not_know_the_recording():
    """Of a test utterance nothing is read but its text; of a training utterance, its fold is left out."""
    poisoned = [replace(one, parameters=np.full_like(one.parameters, np.nan)) for one in TEST]
    for one, other in zip(PREDICTED.encode(TEST), PREDICTED.encode(poisoned), strict=True):
        assert np.array_equal(one.index, other.index)
    changed = list(TRAINING)
    noise = np.random.default_rng(3).normal(0, 1, TRAINING[4].parameters.shape)
    changed[4] = replace(TRAINING[4], parameters=(TRAINING[4].parameters[::-1] + noise).astype(np.float32))
    other = fitted(changed)
    fold = PREDICTED.text.crossfit.fold_of(TRAINING[4].id)
    same = [one for one in TRAINING if PREDICTED.text.crossfit.fold_of(one.id) == fold]
    # The classes, which are learned from all, are held; what is predicted is then that of the same model.
    for one in same:
        values, also = (
            block.text.predict(one.alignment, one.frames, RATE, PHONES, one.id)[0] for block in (PREDICTED, other)
        )
        assert np.allclose(values, also, atol=1e-2)
    differ = other.text.predict(TEST[0].alignment, TEST[0].frames, RATE, PHONES)[0]
    assert not np.allclose(differ, PREDICTED.text.predict(TEST[0].alignment, TEST[0].frames, RATE, PHONES)[0], atol=0.1)


def test_a_recording_of_another_coding_has_no_such_visemes():
    with pytest.raises(DataError, match="3 parameters has no dynamic visemes of 4: they are of another visual coding"):
        list(ORACLE.encode([replace(TEST[0], parameters=TEST[0].parameters[:, :3])]))


def test_more_classes_than_gestures():
    with pytest.raises(
        DataError, match="`classes: 5000` asks for more classes of dynamic visemes than there are gestures"
    ):
        fitted(classes=5000)
    with pytest.raises(DataError, match="no training utterance"):
        fitted([])


def test_gestures_of_a_recording_shorter_than_the_least_length():
    short = replace(TEST[0], frames=3, parameters=TEST[0].parameters[:3])
    (stream,) = ORACLE.encode([short])
    assert len(stream) == 3 and len(set(stream.index[:, 0])) == 1
    (stream,) = context_of(ORACLE).encode([short])
    check_stream(stream, CONTEXT.layout, "ctx")


def test_the_layout_of_the_contexts():
    """Table 1 with 160 classes: a segment of 160 x 5, three positions of a frame, four of each larger unit."""
    many = fitted(corpus(30), source="oracle", classes=160)
    layout = context_of(many).layout
    levels = [4] * (1 + 1 + 2 + 3)
    assert sorted(layout.sizes) == sorted([3, *[160] * 5, *levels]) and many.layout.width == 160
    assert layout.dimension == 4 + 1 + 2 + 3 and layout.width == 3 + 800 + 4 * 7 + 10
    only = context_of(many, features=["viseme_context"]).layout
    assert (only.sizes, only.dimension) == ((160,) * 5, 0)


@pytest.mark.parametrize("one", [*TRAINING[:2], *TEST])
def test_contexts_counted_frame_by_frame(one):
    gestures, classes = PREDICTED.visemes(one)
    names = ["position", "number_of_frames", "forward_span", "viseme_context", "number_of_phones", "syllable"]
    block = context_of(PREDICTED, features=names)
    (stream,) = block.encode([one])
    counts = np.rint(stream.values * block.counts.deviation + block.counts.mean).astype(int)
    of_frame, structure = gestures.of_frames(), structure_of(one.alignment, 0.15)
    ends = [phone.end for phone in one.alignment.phones]
    phone = [
        next((n for n, end in enumerate(ends) if (t + 0.5) / RATE < end), len(ends) - 1) for t in range(one.frames)
    ]
    low, high = block.counts.low, block.counts.high
    for frame in range(one.frames):
        own = np.flatnonzero(of_frame == of_frame[frame])
        assert stream.index[frame, 0] == 3 * (2 * (frame - own[0]) + 1) // (2 * len(own))
        segment = [classes[np.clip(of_frame[frame] + n, 0, len(classes) - 1)] for n in range(-2, 3)]
        assert stream.index[frame, 1:6].tolist() == segment
        syllable = structure.syllable_in_utterance[phone[frame]]
        seen = sorted({of_frame[t] for t in range(one.frames) if structure.syllable_in_utterance[phone[t]] == syllable})
        expected = [len(own), own[-1] - frame + 1, len({phone[t] for t in own}), len(seen) if syllable else 0]
        assert counts[frame].tolist() == np.clip(expected, low, high).tolist()
        place = seen.index(of_frame[frame])
        third = 3 * (2 * place + 1) // (2 * len(seen)) if syllable else NO_POSITION
        assert stream.index[frame, 6] == third
    assert stream.index[:, 6].max() == NO_POSITION == len(POSITIONS)


@pytest.mark.parametrize("block", [PREDICTED, ORACLE, CONTEXT], ids=["predicted", "oracle", "context"])
def test_altered_files_are_refused_or_harmless(tmp_path, block):
    path = tmp_path / "block.safetensors"
    save_block(path, block)
    sound = read_model(path)
    refused = 0
    for number in range(150):
        random = np.random.default_rng([7, number])
        arrays, settings = {name: values.copy() for name, values in sound[0].items()}, copy.deepcopy(sound[1])
        said = alter_plain(settings, random) if number % 2 else alter_arrays(arrays, random)
        try:
            write_model(path, arrays, settings)
        except Exception:  # what cannot be written is no case
            continue
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                again = load_block(path)
                for stream in again.encode(TEST[:1]):
                    check_stream(stream, again.layout, "dv")
        except VisualSpeechError as error:
            refused += 1
            assert not isinstance(error, DamagedFile) or str(path) in str(error), said
    assert refused > 30


def test_a_damaged_block_inside_another_names_the_file(tmp_path):
    path = tmp_path / "block.safetensors"
    save_block(path, CONTEXT)
    arrays, settings = read_model(path)
    arrays["visemes.text.follows"] = arrays["visemes.text.follows"][:-1]
    write_model(path, arrays, settings)
    with pytest.raises(DamagedFile, match=f"cannot read {path}: the array 'follows' has the shape"):
        load_block(path)
