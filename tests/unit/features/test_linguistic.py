"""Contextual features of phones: dimensions of the paper, and each feature against a plain version frame by frame."""

import tracemalloc

import numpy as np
import pytest

from tests.unit.speech.alignments import even_alignment
from visualspeech.errors import DamagedFile, DataError
from visualspeech.features.blocks.base import Source, phones_of, restore
from visualspeech.features.blocks.linguistic import Linguistic, LinguisticSettings
from visualspeech.features.blocks.phone import Phone, PhoneSettings
from visualspeech.features.linguistic import FEATURES, linguistic_columns
from visualspeech.features.streams import check_stream
from visualspeech.models.block_states import BLOCK_ARRAYS, pack, unpack
from visualspeech.speech.acoustic_classes import ACOUSTIC_CLASSES
from visualspeech.speech.phones import PHONES
from visualspeech.speech.spoken import speak_text
from visualspeech.speech.structure import SYMBOLS, structure_of, symbols_of
from visualspeech.speech.substitutes import in_phones
from visualspeech.storage.layouts import check_arrays
from visualspeech.storage.models import read_model, write_model

#: Categorical columns and real values of each feature. Table 1 has the features, section 4 these dimensions: 41 phones,
#: "three binary elements" of a position, 57 acoustic classes, 41 x 5 of a segment. A pause is in no syllable, word and
#: phrase, so positions in those have a fourth class; section 4.3 gives them a number beside each position.
DIMENSIONS = {
    "position": ((3,), 0),
    "number_of_frames": ((), 1),
    "forward_span": ((), 1),
    "acoustic_class": ((), 57),
    "phone_context": ((41, 41, 41, 41, 41), 0),
    "syllable": ((4,), 1),
    "word": ((4,), 1),
    "phrase": ((4, 4), 2),
    "utterance": ((4, 4, 4), 3),
}
WORDS = [
    ("sil", ["sil"]),
    ("computer", "k ah m p y uw t er".split()),
    ("sil", ["sil"]),
    ("extra", "eh k s t r ah".split()),
    ("hmm", ["hh", "m"]),
    ("sil", ["sil", "sil"]),
]
SHORT = even_alignment(WORDS)  # pauses of 0.1 s
TRAINING = [
    Source(200, 100.0, SHORT),
    Source(70, 100.0, even_alignment([("sil", ["sil"]), ("map", ["m", "ae", "p"]), ("sil", ["sil"])], 0.14)),
]


def fitted(training=TRAINING, **settings) -> Linguistic:
    return Linguistic.fit(vars(LinguisticSettings(**settings)), PHONES, iter(training))


@pytest.mark.parametrize("name", FEATURES)
def test_dimensions_are_those_of_the_paper(name):
    layout = fitted(features=(name,)).layout
    assert (layout.sizes, layout.dimension) == DIMENSIONS[name] and not layout.segmental


def test_all_features_and_the_centre_phone():
    assert set(DIMENSIONS) == set(FEATURES)
    assert Phone.fit(vars(PhoneSettings()), PHONES, iter(TRAINING)).layout.sizes == (41,)
    whole = fitted().layout
    assert whole.sizes == tuple(size for name in FEATURES for size in DIMENSIONS[name][0])
    assert whole.dimension == sum(DIMENSIONS[name][1] for name in FEATURES) == 66
    assert whole.width == 3 + 41 * 5 + 4 * 7 + 66


def frame_by_frame(source: Source, long_pause: float):
    """Features of each frame by name, from its phone, counted one frame at a time."""
    phones = source.alignment.phones
    symbols, structure = symbols_of(source.alignment, long_pause), structure_of(source.alignment, long_pause)
    times = [(i + 0.5) / source.rate for i in range(source.frames)]
    unit = [max(n for n, one in enumerate(phones) if one.start <= time) for time in times]
    rows = []
    for i, own in enumerate(unit):
        inside = [j for j, other in enumerate(unit) if other == own]
        around = [symbols[own + k] if 0 <= own + k < len(phones) else "sil" for k in range(-2, 3)]

        def place(small, large, own=own):
            number, count = (getattr(structure, f"{name}_in_{large}")[own] for name in (small, f"{small}s"))
            return (3 if number == 0 else int((number - 0.5) / count * 3)), count

        levels = {
            "syllable": [place("phone", "syllable")],
            "word": [place("syllable", "word")],
            "phrase": [place("syllable", "phrase"), place("word", "phrase")],
            "utterance": [place(name, "utterance") for name in ("syllable", "word", "phrase")],
        }
        rows.append(
            {
                "position": ([int((inside.index(i) + 0.5) / len(inside) * 3)], []),
                "number_of_frames": ([], [len(inside)]),
                "forward_span": ([], [len(inside) - inside.index(i)]),
                "acoustic_class": ([], [symbols[own] in members for members in ACOUSTIC_CLASSES.values()]),
                "phone_context": ([SYMBOLS.index(one) for one in around], []),
                **{name: tuple(map(list, zip(*pairs, strict=True))) for name, pairs in levels.items()},
            }
        )
    return rows


@pytest.mark.parametrize("long_pause", [0.05, 0.2])
@pytest.mark.parametrize("rate", [25.0, 100.0])
def test_every_feature_frame_by_frame(rate, long_pause):
    source = Source(int(2 * rate), rate, SHORT)
    rows = frame_by_frame(source, long_pause)
    for name in FEATURES:
        found = linguistic_columns(SHORT, source.frames, rate, [name], long_pause)
        values = np.concatenate([found.counts, found.classes], axis=1)
        assert found.index.dtype == np.uint8
        assert found.index.tolist() == [row[name][0] for row in rows], name
        assert values.tolist() == [row[name][1] for row in rows], name
    several = ["word", "acoustic_class", "position"]
    found = linguistic_columns(SHORT, source.frames, rate, several, long_pause)
    assert found.index.tolist() == [row["word"][0] + row["position"][0] for row in rows]


def test_streams_hold_small_classes_and_normalised_counts():
    block = fitted()
    streams = list(block.encode(TRAINING))
    values = np.concatenate([stream.values for stream in streams])
    assert all(one.index.dtype == np.uint8 and one.values.dtype == np.float32 for one in streams)
    counts = np.concatenate(
        [linguistic_columns(one.alignment, one.frames, one.rate, list(FEATURES), 0.2).counts for one in TRAINING]
    )
    assert np.allclose(values[:, :9].mean(axis=0), 0, atol=1e-5)
    varied = counts.std(axis=0) > 0
    assert varied.sum() == 9 and np.allclose(values[:, :9].std(axis=0), 1, atol=1e-5)
    for column in range(9):
        assert np.corrcoef(values[:, column], counts[:, column])[0, 1] > 1 - 1e-6
    assert set(np.unique(values[:, 9:])) == {0.0, 1.0}


def test_the_phone_of_each_frame_is_the_middle_of_the_segment():
    phone = Phone.fit(vars(PhoneSettings()), PHONES, iter(TRAINING))
    context = fitted(features=("phone_context",))
    for one, other in zip(phone.encode(TRAINING), context.encode(TRAINING), strict=True):
        assert one.index.dtype == np.uint8 and np.array_equal(one.index[:, 0], other.index[:, 2])
        assert one.values is None and other.values is None
    assert [SYMBOLS[next(phone.encode(TRAINING)).index[at, 0]] for at in (0, 15, 95, 195)] == ["sil", "k", "sp", "sil"]


def test_a_short_pause_is_silence_where_training_has_none():
    for block in (Phone.fit(vars(PhoneSettings()), PHONES, TRAINING[1:]), fitted(TRAINING[1:])):
        assert not block.short_pauses
        index = next(iter(block.encode(TRAINING[:1]))).index
        sp, sil = SYMBOLS.index("sp"), SYMBOLS.index("sil")
        column = 0 if isinstance(block, Phone) else 3  # after `position` and two phones
        assert sp not in index[:, column] and index[95, column] == sil
    assert fitted().short_pauses and not fitted(long_pause=0.05).short_pauses


def test_unknown_phones_are_one_sentence():
    wrong = [Source(10, 100.0, even_alignment([("word", ["s", "xx"])]))]
    for block in (Phone(PHONES), fitted()):
        with pytest.raises(DataError, match="the phone 'xx' of the alignment is not one of the 40 symbols"):
            list(block.encode(wrong))
    with pytest.raises(DataError, match="there is no training utterance"):
        fitted([])


def test_statistics_must_be_those_of_the_features():
    block = fitted()
    arrays, plain = block.state()
    with pytest.raises(DamagedFile, match=r"a file.*there are statistics of 9 counts, the features have 1"):
        restore("linguistic", arrays, {**plain, "features": ["word"]}, "a file")
    with pytest.raises(DamagedFile, match="'xx' is not one of"):
        restore("linguistic", arrays, {**plain, "phones": ["sil", "xx"]}, "a file")
    with pytest.raises(DamagedFile, match=r"`counts.0.deviation` in its settings: 0 is less than the minimum"):
        restore("linguistic", arrays, {**plain, "counts": [{**plain["counts"][0], "deviation": 0}]}, "a file")


@pytest.mark.parametrize("features", [("acoustic_class",), ("position",), tuple(FEATURES)])
def test_a_model_file_holds_any_choice_of_features(tmp_path, features):
    block = fitted(features=features)
    arrays, plain = pack({"ctx": block, "ph": Phone(PHONES)})
    write_model(tmp_path / "model.safetensors", arrays, {"blocks": plain})
    arrays, settings = read_model(tmp_path / "model.safetensors")
    check_arrays("model", arrays, BLOCK_ARRAYS)
    assert unpack(arrays, settings["blocks"]) == {"ctx": block, "ph": Phone(PHONES)}


def test_memory_of_fitting_does_not_grow_with_the_corpus():
    def peak(utterances):
        tracemalloc.start()
        fitted(Source(200, 100.0, SHORT) for _ in range(utterances))
        _, most = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        return most

    kept = 195 * 200 * 9 * 4  # bytes of the counts of 195 more utterances
    assert peak(200) - peak(5) < 0.25 * kept


def test_a_new_text_is_encoded_in_the_phones_of_the_corpus():
    """What is spoken has phones, lengths and pauses that no training utterance has."""
    phones = sorted({one.label for source in TRAINING for one in source.alignment.phones})
    blocks = Phone.fit(vars(PhoneSettings()), phones, TRAINING), Linguistic.fit({}, phones, TRAINING)
    known = {SYMBOLS.index(phone) for phone in (*phones, "sp")}
    text = "Measure the vision of George, please, for azure toys sing, although nobody whatsoever listens to them."
    (one,) = speak_text(text)
    alignment, replaced = in_phones(one.alignment, phones_of(blocks[1]))
    assert {"zh", "jh", "ng", "oy"} <= set(replaced) and phones_of(blocks[0]) == phones_of(blocks[1])
    source = Source(int(alignment.duration * 100), 100.0, alignment)
    phone, context = (next(iter(block.encode([source]))) for block in blocks)
    check_stream(phone, blocks[0].layout, "ph")
    check_stream(context, blocks[1].layout, "ctx")
    assert set(np.unique(phone.index)) <= known and len(np.unique(phone.index)) > 10
    ranges = blocks[1].counts
    low, high = ((limit - ranges.mean) / ranges.deviation for limit in (ranges.low, ranges.high))
    assert (context.values[:, :9] >= low - 1e-5).all() and (context.values[:, :9] <= high + 1e-5).all()
    # The commas are pauses, which end phrases.
    assert structure_of(alignment, 0.1).phrases_in_utterance.max() > 1
