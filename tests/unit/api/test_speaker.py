"""A speaker as a program uses it: frames, a file, bytes, and mistakes."""

import json
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import soundfile

from tests.unit.animation import speakers
from visualspeech import RejectedUtterance, SettingError, Speaker, StorageError
from visualspeech.media.reading import probe, read_audio, read_frames


@pytest.fixture(scope="module")
def speaker(tmp_path_factory):
    return Speaker.load(speakers.make(tmp_path_factory.mktemp("speaker") / "made"))


def test_a_text_becomes_frames_and_a_file(speaker, tmp_path):
    said = speaker.say("Hello.")
    frames = list(said)
    assert len(frames) == round(said.seconds * said.rate) == len(said.parameters)
    assert all(frame.dtype == np.uint8 and frame.shape == frames[0].shape for frame in frames)
    path = said.save(tmp_path / "said.mp4")
    shown = list(read_frames(path))
    assert len(shown) == len(frames) and np.abs(shown[3].astype(float) - frames[3]).mean() < 4
    assert probe(path).audio_rate == said.audio_rate and said.sound.dtype == np.float32
    heard = read_audio(path, said.audio_rate)
    assert len(heard) == pytest.approx(len(said.sound), abs=2048) and np.abs(said.sound).max() > 0.1


@pytest.mark.parametrize(
    ("name", "size", "expected"),
    [("a.mov", None, None), ("b.webm", (96, 64), (96, 64)), ("c.mp4", 64, (80, 64)), ("d.mp4", [64, 96], (64, 96))],
)
def test_other_containers_and_sizes(speaker, tmp_path, name, size, expected):
    path = speaker.say("Hello.").save(tmp_path / name, size=size)
    assert next(iter(read_frames(path))).shape[1::-1] == (expected or speaker.bundle.background.size)


def test_frames_and_timings_are_those_of_the_video(speaker, tmp_path):
    said = speaker.say("Hello. How are you?")
    said.save(tmp_path / "said.mp4", frames=tmp_path / "frames", timings=tmp_path / "said.json")
    assert json.loads((tmp_path / "said.json").read_text()) == said.timings
    assert len(list((tmp_path / "frames").glob("*.png"))) == said.timings["frames"] == len(list(said))
    assert (tmp_path / "frames" / "sound.wav").is_file()
    words = said.timings["words"]
    assert [word["label"] for word in words] == ["hello", "how", "are", "you"]
    assert words[-1]["end"] <= said.seconds == pytest.approx(said.timings["seconds"])


def test_each_request_is_by_itself(speaker, tmp_path):
    first, other = speaker.say("Hello."), speaker.say("Another.", speed=300, label=False)
    again = speaker.say("Hello.")
    assert np.array_equal(first.parameters, again.parameters) and other.seconds != first.seconds
    assert all(np.array_equal(a, b) for a, b in zip(first, again, strict=True))
    assert first.mp4() == again.mp4() == first.save(tmp_path / "a.mp4").read_bytes()
    plain = speaker.say("Hello.", label=False)
    assert not np.array_equal(next(iter(plain)), next(iter(first)))
    assert speaker.consent == speakers.CONSENT


def test_requests_of_several_threads_do_not_disturb_each_other(speaker):
    texts = ["Hello.", "How are you?", "I am well.", "Goodbye."]
    expected = [speaker.say(text).mp4() for text in texts]
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(lambda text: speaker.say(text).mp4(), texts)) == expected


def test_frames_are_rendered_as_they_are_asked_for(speaker, monkeypatch):
    from visualspeech.animation import speaking

    rendered = []
    labelled = speaking.labelled
    monkeypatch.setattr(speaking, "labelled", lambda frame, *given: rendered.append(1) or labelled(frame, *given))
    next(iter(speaker.say("Hello. How are you? I am well.")))
    assert len(rendered) == 1


def test_distances_of_the_background_are_computed_once(speaker, monkeypatch):
    from visualspeech.animation import background

    next(iter(speaker.say("Hello.")))
    monkeypatch.setattr(background, "frame_distances", None)
    next(iter(speaker.say("Again.")))


def test_a_recording_gives_the_voice(speaker, tmp_path):
    said = speaker.say("The boys buy a map.")
    soundfile.write(tmp_path / "said.wav", said.sound, said.audio_rate)
    with_text = speaker.say_recording(tmp_path / "said.wav", "The boys buy a map.")
    heard = speaker.say_recording(tmp_path / "said.wav")
    assert with_text.seconds == pytest.approx(said.seconds, abs=0.1) == heard.seconds
    assert heard.bundle.model == "F-4-mel" and with_text.bundle.model == "F-4"
    assert with_text.timings["words"][-1]["label"] == "map" and heard.timings is None  # the lips follow the sound
    with pytest.raises(SettingError, match=r"timings=.*a.json: the lips follow the sound alone"):
        heard.save(tmp_path / "a.mp4", timings=tmp_path / "a.json")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["said.wav"]
    assert "recording said.wav" in with_text.voice and next(iter(heard)).ndim == 3


@pytest.mark.parametrize(
    ("text", "options", "said"),
    [
        ("", {}, "no word to pronounce"),
        ("?!", {}, "no word to pronounce"),
        ("Hello.", {"voice": "martian"}, "no voice"),
        ("Hello.", {"speed": 20}, "at least 80 and at most 450"),
        ("Hello.", {"pitch": 101}, "at most 100"),
        ("Hello.", {"seed": -1}, "seed=-1: give a number from 0"),
        ("Hello.", {"seed": "a"}, "seed=a: give a number from 0"),
    ],
)
def test_mistakes_are_reported_by_the_call(speaker, text, options, said):
    with pytest.raises(SettingError, match=said):
        speaker.say(text, **options)


def test_other_mistakes(speaker, tmp_path):
    with pytest.raises(StorageError, match="holds no speaker.json"):
        Speaker.load(tmp_path)
    with pytest.raises(SettingError, match=r"said.avi: .* ends in .mp4, .mov or .webm"):
        speaker.say("Hello.").save(tmp_path / "said.avi")
    with pytest.raises(SettingError, match="nothing to write"):
        speaker.say("Hello.").save(timings=tmp_path / "said.json")
    for size, message in {
        (97, 64): "even sizes; give 98 or 96", 20: "from 64 to 4096", (64, 64, 3): r"give \(width, height\)",
        64.5: r"give \(width, height\)", "64x64": r"give \(width, height\)",
    }.items():  # fmt: skip
        with pytest.raises(SettingError, match=f"^size=.*{message}"):
            speaker.say("Hello.").save(tmp_path / "said.mp4", size=size)
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(RejectedUtterance, match="nowhere.wav: the file does not exist"):
        speaker.say_recording(tmp_path / "nowhere.wav", "Hello.")
    with pytest.raises(SettingError, match="is empty"):
        speaker.say_recording(tmp_path / "nowhere.wav", " ")
