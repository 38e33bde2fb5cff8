"""The blocks of speech features: dimensions, normalisation per speaker, rates, new speech, files of strangers."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.unit.speech.voices import harmonics, noise, sentence, sound_of
from visualspeech.errors import DamagedFile, DataError, SettingError
from visualspeech.features.blocks.base import Source, load_block, restore, save_block, with_unseen_speakers
from visualspeech.features.blocks.speech27 import Speech27
from visualspeech.features.blocks.speech44 import Speech44
from visualspeech.features.speech_block import LIMIT, SpeechSettings, features_at
from visualspeech.fields import with_defaults
from visualspeech.speech import egemaps
from visualspeech.speech.sound import Sound
from visualspeech.speech.speech_features import RATE, Extractor

needs_opensmile = pytest.mark.skipif(bool(egemaps.missing()), reason=egemaps.missing())
KINDS = [Speech27, pytest.param(Speech44, marks=needs_opensmile)]
PRAAT = Extractor(False, 75.0, 600.0)
ENERGY = Speech27.names().index("energy")


def source(name="one", speaker="ann", hertz=120.0, gain=1.0, rate=25.0, seconds=2.0, seed=None):
    seed = sum(map(ord, name)) if seed is None else seed
    samples = sentence(seconds, hertz, seed) * gain + noise(seconds, 1e-4, seed)
    return Source(int(seconds * rate), rate, sound=sound_of(samples), id=name, speaker=speaker)


#: A quiet low voice and a loud high one.
TRAINING = [
    *(source(f"a{number}", "ann", 110.0, 0.2) for number in range(4)),
    *(source(f"b{number}", "bob", 220.0, 1.0) for number in range(3)),
]


def fit(cls, training, **settings):
    return cls.fit(with_defaults(SpeechSettings, settings), (), iter(training))


@cache
def fitted(cls=Speech27, scaling="speaker"):
    return fit(cls, TRAINING, scaling=scaling)


def values(block, *sources):
    return np.concatenate([one.values for one in block.encode(list(sources))])


@pytest.mark.parametrize("cls", KINDS)
def test_dimensions_and_files(cls, tmp_path):
    block = fitted(cls)
    dimension = {"speech27": 27, "speech44": 44}[cls.kind]
    assert block.layout.dimension == dimension == len(cls.names()) and block.layout.sizes == ()
    found = values(block, *TRAINING)
    assert found.shape == (7 * 50, dimension) and found.dtype == np.float32 and np.isfinite(found).all()
    save_block(tmp_path / "block.safetensors", block)
    again = load_block(tmp_path / "block.safetensors")
    assert again == block and again != block.for_new_speech() and set(again.speakers) == {"ann", "bob"}
    assert np.array_equal(values(again, *TRAINING), found)
    new = block.for_new_speech()
    save_block(tmp_path / "new.safetensors", new)
    assert load_block(tmp_path / "new.safetensors") == new and not new.speakers


@pytest.mark.parametrize("cls", KINDS)
def test_training_utterances_of_each_speaker_have_mean_0_and_variance_1(cls):
    block = fitted(cls)
    for speaker in ("ann", "bob"):
        found = values(block, *(one for one in TRAINING if one.speaker == speaker))
        assert np.abs(found).max() <= LIMIT
        inside = np.abs(found).max(axis=0) < LIMIT
        assert np.abs(found.mean(axis=0))[inside].max() < 1e-4
        assert np.abs(found.std(axis=0) - 1)[inside].max() < 1e-3 and inside.sum() > 0.9 * len(inside)
    # With those of the corpus the loud voice stays louder than the quiet one.
    block = fitted(cls, scaling="corpus")
    ann, bob = (values(block, *(one for one in TRAINING if one.speaker == who)) for who in ("ann", "bob"))
    assert bob[:, ENERGY].mean() - ann[:, ENERGY].mean() > 0.5
    both = np.concatenate([ann, bob])
    assert np.abs(both.mean(axis=0))[:27].max() < 1e-3 and np.abs(both.std(axis=0) - 1)[:27].max() < 1e-3


def test_statistics_against_a_plain_computation():
    found = fitted()
    of_ann = np.concatenate([features_at(PRAAT, one.sound, 50, 25.0) for one in TRAINING if one.speaker == "ann"])
    of_all = np.concatenate([features_at(PRAAT, one.sound, 50, 25.0) for one in TRAINING])
    assert np.allclose(found.speakers["ann"].mean, of_ann.mean(axis=0))
    assert np.allclose(found.speakers["ann"].deviation, of_ann.std(axis=0))
    assert np.allclose(found.corpus.mean, of_all.mean(axis=0))
    assert np.allclose(found.corpus.deviation, of_all.std(axis=0))


def test_statistics_are_of_training_utterances_alone():
    block, other = fitted(), source("test", "ann", 110.0, 0.02)
    expected = (features_at(PRAAT, other.sound, 50, 25.0) - block.speakers["ann"].mean) / block.speakers[
        "ann"
    ].deviation
    assert np.allclose(values(block, other), expected, atol=1e-4) and values(block, other)[:, ENERGY].mean() < -0.5
    (alone,), (among, _) = block.encode([other]), block.encode([other, source("more", "ann", gain=1.0)])
    assert np.array_equal(alone.values, among.values)


def test_a_speaker_without_training_utterances_has_the_statistics_of_all_his_own():
    cleo = [source("c0", "cleo", 180.0, 0.05), source("c1", "cleo", 180.0, 0.8)]
    block = fitted()
    extended = with_unseen_speakers(block, cleo)
    found = values(extended, *cleo)
    assert np.abs(found.mean(axis=0)).max() < 1e-3 and np.abs(found.std(axis=0) - 1).max() < 1e-2
    assert found[50:, ENERGY].mean() > found[:50, ENERGY].mean() + 0.5  # the two are not levelled
    # Nothing that was learned from training utterances changes.
    assert np.array_equal(values(extended, *TRAINING), values(block, *TRAINING))
    assert np.array_equal(extended.corpus.mean, block.corpus.mean)
    # A speaker of the training utterances keeps theirs, and with those of the corpus nothing is added.
    assert with_unseen_speakers(block, [source("a9", "ann", gain=0.01)]) == block
    assert with_unseen_speakers(fitted(scaling="corpus"), cleo) == fitted(scaling="corpus")


def test_new_speech_has_its_own_statistics():
    block = fitted()
    new = replace(source("new", gain=0.4), speaker="", id="")
    found = values(block, new)
    assert np.abs(found.mean(axis=0)).max() < 1e-4 and np.abs(found.std(axis=0) - 1).max() < 1e-3
    quiet = replace(new, sound=sound_of(new.sound.samples / 32767 * 0.25))
    assert np.abs(values(block, quiet)[:, [0, 1, 26]] - found[:, [0, 1, 26]]).mean() < 0.1  # the level does not matter
    assert np.array_equal(values(block.for_new_speech(), new), found)
    assert np.array_equal(values(block, replace(new, speaker="nobody")), found)


@pytest.mark.parametrize("rate", [25.0, 29.97, 50.0, 120.0])
def test_a_part_of_new_speech_is_that_part_of_all_of_it(rate):
    block, sound = fitted(), source("new", seconds=3.0).sound
    frames = int(3 * rate)
    (whole,) = block.encode([Source(frames, rate, sound=sound)])
    borders = (0, frames // 3, frames // 3 + 1, frames)
    pieces = [Source(b - a, rate, sound=sound, begin=a / rate) for a, b in zip(borders[:-1], borders[1:], strict=True)]
    assert np.allclose(np.concatenate([one.values for one in block.encode(pieces)]), whole.values, atol=1e-4)


@pytest.mark.parametrize(("rate", "frames"), [(120.0, 240), (240.0, 480), (147.3, 290)])
def test_at_high_rates_features_are_interpolated_linearly(rate, frames):
    sound = source().sound
    grid = PRAAT.features(sound, 0, 240)
    times, own = (np.arange(frames) + 0.5) / rate, (np.arange(240) + 0.5) / RATE
    plain = np.column_stack([np.interp(times, own, column) for column in grid.T])
    assert np.allclose(features_at(PRAAT, sound, frames, rate), plain)


@pytest.mark.parametrize("rate", [25.0, 60.0, 100.0])
def test_at_low_rates_a_frame_has_the_mean_over_its_duration(rate):
    sound = source().sound
    grid, own = PRAAT.features(sound, 0, 240), (np.arange(240) + 0.5) / RATE
    frames, fine = int(2 * rate), 400
    times = (np.arange(frames * fine) + 0.5) / rate / fine
    plain = np.column_stack([np.interp(times, own, column).reshape(frames, fine).mean(axis=1) for column in grid.T])
    assert np.allclose(features_at(PRAAT, sound, frames, rate), plain, atol=1e-2)


@pytest.mark.parametrize("cls", KINDS)
@pytest.mark.parametrize("frames", [1, 2, 75])
@pytest.mark.parametrize("kind", ["nothing", "one", "silent", "noise", "tone"])
def test_sounds_that_say_nothing_have_finite_features(cls, frames, kind):
    block = fitted(cls)
    samples = {"nothing": np.zeros(0), "one": np.ones(1), "silent": np.zeros(48_000), "noise": noise(3.0, 0.001),
               "tone": harmonics(150.0, 3.0)}[kind]  # fmt: skip
    for speaker in ("", "ann", "nobody"):
        found = values(block, Source(frames, 25.0, sound=sound_of(samples), speaker=speaker))
        assert found.shape == (frames, block.layout.dimension)
        assert np.isfinite(found).all() and np.abs(found).max() <= LIMIT
        if kind in ("nothing", "silent") and speaker != "ann":
            assert np.abs(found).max() < 1e-6  # all of it is its mean


def test_a_sound_that_is_shorter_than_the_face_goes_on_as_it_ends():
    block, one = fitted(), source(seconds=1.0, seed=3)
    longer = replace(one, frames=40)
    found, shorter = features_at(PRAAT, one.sound, 40, 25.0), features_at(PRAAT, one.sound, 25, 25.0)
    assert np.allclose(found[:24], shorter[:24]) and np.ptp(found[26:], axis=0).max() < 1e-9
    assert np.isfinite(values(block, longer)).all()
    late = replace(one, frames=10, begin=5.0)
    assert np.ptp(values(block, late), axis=0).max() == 0


def test_without_voice_f0_is_the_mean_and_statistics_are_those_of_voice():
    f0 = Speech27.names().index("log_f0")
    whisper = Source(50, 25.0, sound=sound_of(noise(2.0, 0.02)), speaker="ann", id="whisper")
    block = fit(Speech27, [*TRAINING, whisper])
    assert np.allclose(block.speakers["ann"].mean[f0], fitted().speakers["ann"].mean[f0])
    assert (values(block, whisper)[:, f0] == 0).all()
    mute = fit(Speech27, [replace(whisper, speaker="mute"), *TRAINING])
    assert mute.speakers["mute"].mean[f0] == mute.corpus.mean[f0]
    assert (values(mute, replace(whisper, speaker="mute"))[:, f0] == 0).all()


def test_without_sound_or_training_it_cannot_be_computed():
    with pytest.raises(DataError, match="speech27 is computed from sound"):
        list(fitted().encode([Source(3, 25.0)]))
    with pytest.raises(DataError, match="no training utterance"):
        fit(Speech27, [])


def test_speech44_without_opensmile(monkeypatch):
    monkeypatch.setattr(egemaps, "find_spec", lambda name: None)
    assert "'.[egemaps]'" in Speech44.unavailable()
    with pytest.raises(DataError, match="opensmile is not installed"):
        fit(Speech44, [replace(TRAINING[0], sound=Sound(np.zeros(7, np.int16)))])
    assert fit(Speech27, TRAINING[:1]).layout.dimension == 27


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"scaling": "utterance"}, "scaling: utterance.*speaker, corpus"),
        ({"pitch_floor": 10}, "pitch_floor: 10.*at least 40"),
        ({"pitch_ceiling": 200}, "pitch_ceiling: 200.*at least 250"),
    ],
)
def test_settings_that_make_no_sense_are_a_sentence(settings, said):
    with pytest.raises(SettingError, match=said):
        SpeechSettings(**settings)


@pytest.mark.parametrize(
    "changes",
    [
        {"scaling": "x"}, {"pitch_floor": 0}, {"pitch_floor": 500}, {"pitch_ceiling": 1e9}, {"speakers": ["ann"]},
        {"speakers": ["ann", "ann"]}, {"speakers": ["ann", 3]}, {"speakers": None}, {"more": 1},
        {"mean": np.zeros((3, 26))}, {"mean": np.full((3, 27), np.nan)}, {"deviation": np.zeros((3, 27))},
        {"deviation": np.ones((2, 27))}, {"deviation": np.full((3, 27), 1e300)}, {"mean": np.zeros((0, 27))},
        {"mean": np.zeros((3, 27), int)}, {"other": np.zeros(2)},
    ],
)  # fmt: skip
def test_states_of_strangers_are_refused(changes):
    arrays, plain = fitted().state()
    other = {name: value for name, value in changes.items() if isinstance(value, np.ndarray)}
    changed = {name: value for name, value in changes.items() if name not in other}
    with pytest.raises(DamagedFile, match="model.safetensors"):
        restore("speech27", {**arrays, **other}, {**plain, **changed}, "model.safetensors")
    assert restore("speech27", arrays, plain) == fitted()
