import io
import wave

import cv2
import numpy as np
import pytest

from visualspeech.animation.frame_files import barred, save_sound, saved, scaled, size_of, with_texts

rng = np.random.default_rng(0)
FRAME = rng.integers(0, 255, (40, 60, 3), np.uint8)


def test_frames_are_scaled_and_centred_on_black():
    for function in (scaled, barred):
        assert function(FRAME, None) is FRAME and function(FRAME, (60, 40)) is FRAME
    white = np.full((40, 60, 3), 255, np.uint8)
    whole = (slice(None), slice(None))
    bars = {(60, 60): (slice(10, 50), slice(None)), (120, 40): (slice(None), slice(30, 90))}
    for size, inside in {(120, 80): whole, (30, 20): whole, **bars}.items():
        made = barred(scaled(white, size), size)
        assert made.shape == (size[1], size[0], 3)
        expected = np.zeros_like(made)
        expected[inside] = 255
        np.testing.assert_array_equal(made, expected)


def test_a_height_alone_keeps_the_shape_of_the_recordings():
    assert size_of(None, (360, 288)) is None and size_of((64, 80), (360, 288)) == (64, 80)
    assert size_of(576, (360, 288)) == (720, 576) and size_of(480, (360, 288)) == (600, 480)
    assert size_of(64, (1920, 1080)) == (114, 64)


def test_pngs_hold_the_frames_and_say_what_they_are(tmp_path):
    from PIL import Image

    texts = {"title": "synthetic talking head: Café", "synthetic": "yes"}
    frames = [np.roll(FRAME, i, axis=0) for i in range(3)]
    assert all(a is b for a, b in zip(saved(iter(frames), tmp_path, texts), frames, strict=True))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["000001.png", "000002.png", "000003.png"]
    for number, frame in enumerate(frames, start=1):
        read = cv2.imread(str(tmp_path / f"{number:06d}.png"))
        np.testing.assert_array_equal(cv2.cvtColor(read, cv2.COLOR_BGR2RGB), frame)
    with Image.open(tmp_path / "000001.png") as image:
        assert image.text == texts


def test_texts_do_not_break_a_png():
    from PIL import Image

    coded = cv2.imencode(".png", FRAME)[1].tobytes()
    with Image.open(io.BytesIO(with_texts(coded, {"k": "x" * 5000, "empty": ""}))) as image:
        image.verify()
    assert with_texts(coded, {}) == coded


@pytest.mark.parametrize("rate", [16000, 22050])
def test_sound_is_a_wav_of_16_bits(tmp_path, rate):
    sound = np.linspace(-1.2, 1.0, 3000).astype(np.float32)
    save_sound((sound[i : i + 700] for i in range(0, 3000, 700)), rate, tmp_path / "s.wav")
    with wave.open(str(tmp_path / "s.wav")) as file:
        assert (file.getnchannels(), file.getsampwidth(), file.getframerate()) == (1, 2, rate)
        read = np.frombuffer(file.readframes(9999), "<i2")
    np.testing.assert_array_equal(read, np.clip(np.rint(sound * 32768), -32768, 32767))
