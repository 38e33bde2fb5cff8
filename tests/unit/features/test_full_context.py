"""Full-context phones: neighbours and places in the utterance as columns, against a known structure."""

import numpy as np
import pytest

from tests.unit.speech.alignments import even_alignment
from tests.unit.speech.test_structure import EXPECTED, utterance
from visualspeech.errors import DataError, SettingError, StorageError
from visualspeech.features.blocks import base
from visualspeech.features.blocks.base import Source, block_class
from visualspeech.features.blocks.full_context import FACTORS, FullContext, FullContextSettings
from visualspeech.features.contexts import phone_inventory
from visualspeech.features.streams import check_stream
from visualspeech.fields import with_defaults

SPOKEN = utterance()
PHONES = tuple(phone_inventory([SPOKEN]))


def encoded(alignment=SPOKEN, phones=PHONES, **settings):
    block = FullContext.fit(with_defaults(FullContextSettings, settings), phones, ())
    (stream,) = block.encode([Source(60, 25.0, alignment)])
    check_stream(stream, block.layout, "context")
    return block, stream


def test_columns_of_phones_are_those_of_quinphones():
    block, stream = encoded()
    assert block.layout.sizes == (len(PHONES) + 1,) * 5 + (21,) * 21 and block.layout.segmental
    assert block.symbols == (*PHONES, "sp")
    names = np.array(block.symbols)[stream.index[:, :5]].tolist()
    assert names[0] == ["sil", "sil", "sil", "eh", "k"] and names[-1] == ["hh", "m", "sil", "sil", "sil"]
    assert names[8] == ["ah", "sp", "k", "ah", "m"]  # the pause within the phrase; the longer one ends it
    assert names[16] == ["t", "er", "z", "sil", "hh"]
    assert np.allclose(stream.starts, [one.start for one in SPOKEN.phones])


def test_columns_of_numbers_are_positions_from_both_ends_and_counts():
    _, stream = encoded()
    column = dict(zip(FACTORS, stream.index[:, 5:].T.tolist(), strict=True))
    expected = {name.replace("_", " "): values for name, values in EXPECTED.items()}
    for name, values in expected.items():
        assert column[name] == values, name
    for name in set(FACTORS) - set(expected):
        unit, whole = name.split(" from the end of ")
        pairs = zip(expected[f"{unit} in {whole}"], expected[f"{unit}s in {whole}"], strict=True)
        assert column[name] == [count and count - number + 1 for number, count in pairs], name


def test_settings():
    block, stream = encoded(neighbours=1, max_number=2, long_pause=0.05)
    assert block.layout.sizes == (len(PHONES) + 1,) * 3 + (3,) * 21
    _, plain = encoded(neighbours=1, long_pause=0.05)
    assert np.array_equal(stream.index, np.minimum(plain.index, np.array([99] * 3 + [2] * 21)))
    assert len(PHONES) not in plain.index[:, :3]  # no pause is short
    assert plain.index[:, 3 + FACTORS.index("phrases in utterance")].max() == 3
    with pytest.raises(SettingError, match="`blocks.max_number: 0`"):
        FullContextSettings(max_number=0)


def test_a_word_is_its_own_phrase_and_utterance():
    _, stream = encoded(even_alignment([("sil", ["sil"]), ("baa", ["b", "aa"]), ("sil", ["sil"])]), ("sil", "aa", "b"))
    spoken = stream.index[stream.index[:, 2] > 0]
    assert spoken[:, 5:8].tolist() == [[1, 2, 2], [2, 1, 2]] and (spoken[:, 8:] == 1).all()


def test_phones_that_are_not_known():
    with pytest.raises(DataError, match="the inventory of 3 phones does not have .*eh"):
        encoded(phones=("sil", "aa"))
    strange = SPOKEN.phones[1].__class__("qq", 0.3, 0.4, 1)
    with pytest.raises(DataError, match="the phone 'qq' of the alignment is not one of the 40 symbols"):
        encoded(SPOKEN.__class__(SPOKEN.words, (SPOKEN.phones[0], strange, *SPOKEN.phones[2:]), ()))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"neighbours": 99}, "neighbours"),
        ({"max_number": "3"}, "max_number"),
        ({"more": 1}, "more"),
        ({}, "long_pause"),
    ],
)
def test_state_that_is_none(change, said):
    _, plain = FullContext(PHONES).state()
    plain = {**plain, **change} if change else {key: value for key, value in plain.items() if key != said}
    with pytest.raises(StorageError, match=f"block.safetensors.*{said}"):
        base.restore("full_context", {}, plain, "block.safetensors")


def test_the_kind():
    assert block_class("full_context") is FullContext and FullContext.kind == "full_context"
