import numpy as np
import pytest

from visualspeech.errors import SettingError
from visualspeech.features.labels import label_indices
from visualspeech.media.reading import read_audio
from visualspeech.speech.phones import PHONES, SILENCE
from visualspeech.speech.spoken import THIRDS, speak_recording, speak_text, state_shares, timed
from visualspeech.speech.spoken_settings import VoiceSettings
from visualspeech.speech.tts import synthesise


@pytest.fixture(scope="module")
def spoken():
    return list(speak_text("Baby boys play. They buy a map."))


def test_every_tier_covers_the_sound_without_a_gap(spoken):
    for one in spoken:
        for tier in (one.alignment.words, one.alignment.phones, one.alignment.states):
            starts, ends = np.array([s.start for s in tier]), np.array([s.end for s in tier])
            assert starts[0] == 0 and np.array_equal(starts[1:], ends[:-1]) and (ends > starts).all()
            assert ends[-1] == pytest.approx(len(one.samples) / one.rate)
        assert len(one.alignment.states) == 3 * len(one.alignment.phones)
        assert [s.label for s in one.alignment.states[:3]] == ["1", "2", "3"]


def test_sentences_begin_and_end_in_silence(spoken):
    settings = VoiceSettings()
    assert [one.text for one in spoken] == ["Baby boys play.", "They buy a map."]
    for one in spoken:
        assert one.alignment.phones[0].label == one.alignment.phones[-1].label == SILENCE
        assert np.abs(one.samples[: round(0.2 * one.rate)]).max() == 0
    assert spoken[0].alignment.phones[0].end == pytest.approx(settings.leading_silence, abs=0.02)
    gap = spoken[0].alignment.phones[-1], spoken[1].alignment.phones[0]
    assert gap[0].end - gap[0].start + gap[1].end > settings.sentence_pause - 0.02
    assert [word.label for word in spoken[0].alignment.words] == ["sil", "baby", "boys", "play", "sil"]


def test_the_times_are_those_of_the_voice(spoken):
    speech = synthesise("Baby boys play.", rate_wpm=VoiceSettings().rate_wpm)
    of_voice = [(phone, start, end) for phone, start, end in speech.phones if phone != SILENCE]
    here = [(s.label, s.start - 0.4, s.end - 0.4) for s in spoken[0].alignment.phones if s.label != SILENCE]
    assert [phone for phone, *_ in here] == [phone for phone, *_ in of_voice]
    assert np.allclose([t for _, *t in here], [t for _, *t in of_voice], atol=1e-4)


def test_states_take_their_average_shares():
    alignment = timed([("sil", 0, 0.3), ("aa", 0.3, 0.8), ("b", 0.8, 1.1)], [("ab", 0.3, 1.1)], {"aa": (0.2, 0.5, 0.3)})
    assert np.allclose([s.start for s in alignment.states], [0, 0.1, 0.2, 0.3, 0.4, 0.65, 0.8, 0.9, 1.0])
    assert [(w.label, w.start, w.end) for w in alignment.words] == [("sil", 0, 0.3), ("ab", 0.3, 1.1)]
    assert [p.parent for p in alignment.phones] == [0, 1, 1]
    shares = state_shares(iter([alignment, alignment]))
    assert shares["aa"] == pytest.approx((0.2, 0.5, 0.3)) and shares["b"] == pytest.approx(THIRDS)
    assert shares["sil"] == THIRDS
    labels = label_indices(alignment, 11, 10.0, PHONES)
    assert [PHONES[i] for i in labels[:, 1]] == ["sil"] * 3 + ["aa"] * 5 + ["b"] * 3
    assert labels[3:8, 3].tolist() == [0, 1, 1, 2, 2]


def test_texts_and_settings_that_cannot_be_spoken():
    with pytest.raises(SettingError, match="no word to pronounce"):
        next(speak_text("..."))
    with pytest.raises(SettingError, match="no voice"):
        next(speak_text("Hello.", VoiceSettings(voice="martian")))
    with pytest.raises(SettingError, match="pause"):
        VoiceSettings(sentence_pause=-1)


def test_a_recording_is_aligned_with_its_words(tmp_path):
    import soundfile

    speech = next(iter(speak_text("The baby boys play with a map.")))
    path = tmp_path / "said.wav"
    soundfile.write(path, speech.samples, speech.rate)
    (found,) = speak_recording(path, "The baby boys play with a map.", 25.0)
    assert [w.label for w in found.alignment.words if w.label != SILENCE] == "the baby boys play with a map".split()
    true = [w.start for w in speech.alignment.words if w.label == "baby"][0]
    assert [w.start for w in found.alignment.words if w.label == "baby"][0] == pytest.approx(true, abs=0.08)
    assert len(found.samples) == pytest.approx(len(speech.samples) / speech.rate * found.rate, abs=found.rate / 10)
    assert np.abs(read_audio(path, 16_000)).max() > 0.1
    with pytest.raises(SettingError, match="is empty"):
        next(speak_recording(path, "  ", 25.0))
