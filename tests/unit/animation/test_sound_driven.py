"""Speakers that a recording drives by its sound: the second model of a folder, pieces, pauses, errors."""

import json
import subprocess
import sys

import numpy as np
import pytest
import soundfile

from tests.unit.animation import speakers
from tests.unit.speech.test_segmentation import recording
from visualspeech import cli
from visualspeech.animation.bundle import DESCRIPTION, FILES, SpeakerBundle
from visualspeech.animation.performance import MARGIN, perform
from visualspeech.errors import DataError, RejectedUtterance, StorageError
from visualspeech.features.blocks.base import Source
from visualspeech.media.reading import probe
from visualspeech.models.inventory import needs_of_model, predict_source
from visualspeech.provenance import file_digest
from visualspeech.speech import spoken
from visualspeech.speech.sound import RATE
from visualspeech.speech.spoken import speak_recording, speak_sound, speak_text, spooled


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return speakers.make(tmp_path_factory.mktemp("speaker") / "both")


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """A speaker of a corpus without transcripts."""
    return speakers.make(tmp_path_factory.mktemp("speaker") / "alone", ("sil", "spn"), text=False)


@pytest.fixture(scope="module")
def wav(tmp_path_factory):
    """Seven seconds with pauses, at another sample rate."""
    path = tmp_path_factory.mktemp("sound") / "speech.wav"
    samples = recording((0.6, 0), (1.5, 3000), (0.5, 0), (1.2, 2500), (0.8, 0), (1.6, 3000), (0.8, 0))
    soundfile.write(path, np.repeat(samples, 3), 3 * RATE)
    return path


def test_a_folder_holds_a_second_model_for_recordings(folder, alone):
    both, one = SpeakerBundle.load(folder), SpeakerBundle.load(alone)
    assert needs_of_model(both.trained) == {"text"} and needs_of_model(both.sound) == {"audio"}
    assert not both.reads_sound_alone and both.for_recordings().reads_sound_alone
    assert both.for_recordings().model == "F-4-mel" and both.for_recordings().digest == both.digest
    assert one.sound is None and one.reads_sound_alone and one.for_recordings() is one
    assert not (alone / FILES["sound"]).exists()


def test_a_recording_is_shown_in_pieces_as_it_is_as_a_whole(folder, wav, monkeypatch):
    bundle = SpeakerBundle.load(folder).for_recordings()
    whole = perform(speak_sound(wav, 25.0), bundle.trained, bundle.rest)
    monkeypatch.setattr(spoken, "PIECE", 1.3)
    pieces = list(speak_sound(wav, 25.0, "What is said."))
    assert len(pieces) == 6 and [one.text for one in pieces] == ["What is said.", *[""] * 5]
    made = perform(pieces, bundle.trained, bundle.rest)
    assert len(made.appearance) == len(whole.appearance) == 175 and made.audio_rate == 48000
    assert np.array_equal(made.samples[:], whole.samples[:])
    assert np.abs(made.appearance[:] - whole.appearance[:]).max() < 1e-4 * np.abs(whole.appearance[:]).max()
    # In its pauses the face is at rest, in speech it is the model's.
    assert np.allclose(whole.appearance[5:10], bundle.rest, atol=1e-4)
    (one,) = (Source(175, 25.0, sound=spooled(wav)),)
    predicted = predict_source(bundle.trained, one)
    assert np.allclose(whole.appearance[25:45], predicted[25:45], atol=1e-5)
    assert np.abs(whole.appearance[25:45] - bundle.rest).max() > 1e-3


def test_a_piece_hears_what_lies_beside_it(folder, wav, monkeypatch):
    """Networks look back and ahead; a piece by itself would begin as a recording does."""
    bundle, seen = SpeakerBundle.load(folder).for_recordings(), []
    monkeypatch.setattr(spoken, "PIECE", 2.0)
    monkeypatch.setattr(
        type(bundle.trained),
        "predict",
        lambda self, streams, frames, rate: seen.append(frames) or np.zeros((frames, self.outputs), np.float32),
    )
    perform(speak_sound(wav, 25.0), bundle.trained, bundle.rest)
    margin = round(MARGIN * 25)
    assert seen == [50 + margin, 50 + 2 * margin, 50 + 2 * margin, 25 + margin]


def test_a_text_is_shown_by_the_sound_of_its_voice(alone):
    bundle = SpeakerBundle.load(alone)
    made = perform(speak_text("A happy map.", shares=bundle.shares), bundle.trained, bundle.rest)
    assert made.audio_rate == 22050 and np.ptp(made.appearance[:], axis=0).max() > 1e-3
    assert np.allclose(made.appearance[:3], bundle.rest, atol=1e-4)


def test_a_model_may_read_both(folder, wav, tmp_path):
    bundle = SpeakerBundle.load(folder)
    blocks = {**bundle.trained.blocks, **bundle.sound.blocks}
    model = speakers.network(np.tile(bundle.rest, (4, 1)) + np.eye(4, len(bundle.rest)), blocks, 25.0, "")
    assert needs_of_model(model) == {"audio", "text"}
    made = perform(speak_text("A map."), model, bundle.rest)
    assert np.isfinite(made.appearance[:]).all()
    path = tmp_path / "said.wav"
    (one,) = speak_text("The baby boys play with a map.")
    soundfile.write(path, one.samples, one.rate)
    found = list(speak_recording(path, "The baby boys play with a map.", 25.0, with_sound=True))
    assert [part.begin for part in found] == [0] and found[0].sound.seconds == pytest.approx(
        len(one.samples) / one.rate, abs=0.01
    )
    assert np.isfinite(perform(found, model, bundle.rest).appearance[:]).all()


@pytest.mark.parametrize(
    ("samples", "said"),
    [
        (np.random.default_rng(0).normal(0, 0.1, RATE), "no speech"),
        (np.zeros(RATE), "no speech"),
        (np.random.default_rng(0).normal(0, 0.1, 16), "only 0.001 s of sound"),
    ],
)
def test_sound_without_speech_is_a_sentence(folder, tmp_path, samples, said, capsys):
    path = tmp_path / "a.wav"
    soundfile.write(path, samples, RATE)
    with pytest.raises(RejectedUtterance, match=said):
        next(speak_sound(path, 25.0))
    arguments = ["speak", "--model", str(folder), "--audio", str(path), "-o", str(tmp_path / "a.mp4")]
    assert cli.main(arguments) == 1
    error = capsys.readouterr().err
    assert said in error and str(path) in error and not (tmp_path / "a.mp4").exists()


def test_the_command_takes_the_second_model_for_a_recording_without_a_text(folder, alone, wav, tmp_path):
    for speaker, model in ((folder, "F-4-mel"), (alone, "F-4")):
        path = tmp_path / f"{speaker.name}.mp4"
        command = [sys.executable, "-m", "visualspeech", "speak", "--model", speaker, "--audio", wav, "-o", path]
        done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        assert f"the lips follow the sound of the recording (model {model})" in done.stderr
        assert "recognised" not in done.stderr and probe(path).duration == pytest.approx(7.0, abs=0.1)


def altered(folder, target, change):
    """A copy of a speaker with a changed description and parts, and digests that fit."""
    import shutil

    shutil.copytree(folder, target)
    about = json.loads((target / DESCRIPTION).read_text())
    change(target, about)
    for name in about["parts"]:
        about["parts"][name] = file_digest(target / FILES[name])
    (target / DESCRIPTION).write_text(json.dumps(about))
    return target


def test_a_second_model_that_reads_text_is_refused(folder, tmp_path):
    def change(target, about):
        (target / FILES["sound"]).write_bytes((target / FILES["model"]).read_bytes())

    with pytest.raises(DataError, match="must read sound and nothing else"):
        SpeakerBundle.load(altered(folder, tmp_path / "a", change))
    (folder_without,) = (altered(folder, tmp_path / "b", lambda target, about: about["parts"].pop("sound")),)
    assert SpeakerBundle.load(folder_without).sound is None
    (folder_without / FILES["model"]).unlink()
    with pytest.raises(StorageError, match="lacks model.safetensors"):
        SpeakerBundle.load(folder_without)


def test_a_missing_second_model_is_named(folder, tmp_path):
    made = altered(folder, tmp_path / "a", lambda target, about: None)
    (made / FILES["sound"]).unlink()
    with pytest.raises(StorageError, match="lacks sound.safetensors"):
        SpeakerBundle.load(made)
