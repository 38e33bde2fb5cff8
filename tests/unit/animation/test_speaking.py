import json
from itertools import islice

import av
import numpy as np
import pytest

from tests.unit.animation import speakers
from visualspeech.animation import speaking
from visualspeech.animation.bundle import FILES, SpeakerBundle, check_together
from visualspeech.animation.performance import perform
from visualspeech.animation.speaking import scene, speak, speaking_frames
from visualspeech.animation.speaking_settings import SpeakSettings
from visualspeech.errors import DataError, SettingError, StorageError
from visualspeech.features.blocks.label_parts import LabelParts
from visualspeech.features.blocks.triphone_state import TriphoneState
from visualspeech.features.resampling import resample
from visualspeech.media.reading import probe, read_audio, read_frames
from visualspeech.media.spooling import Spool
from visualspeech.models.inventory import phones_of
from visualspeech.models.rest import REST, pause_weights
from visualspeech.provenance import file_digest
from visualspeech.speech.phones import PHONES
from visualspeech.speech.spoken import Spoken, speak_text, timed
from visualspeech.speech.spoken_settings import VoiceSettings
from visualspeech.speech.substitutes import in_phones
from visualspeech.storage.models import read_model, write_model


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return speakers.make(tmp_path_factory.mktemp("speaker") / "made")


@pytest.fixture(scope="module")
def bundle(folder):
    return SpeakerBundle.load(folder)


@pytest.fixture
def copy(folder, tmp_path):
    import shutil

    return shutil.copytree(folder, tmp_path / "copy")


def test_a_speaker_loads_with_all_that_belongs_to_it(bundle):
    assert (bundle.corpus, bundle.model, bundle.consent) == ("drawn", "F-4", speakers.CONSENT)
    assert phones_of(bundle.trained) == PHONES and bundle.shares["aa"] == (0.2, 0.5, 0.3)
    assert len(bundle.background) == sum(speakers.LENGTHS) and len(bundle.digest) == 12


def test_parts_of_two_speakers_are_not_mixed(copy, tmp_path):
    other = speakers.make(tmp_path / "other", seed=5)
    (copy / FILES["aam"]).write_bytes((other / FILES["aam"]).read_bytes())
    with pytest.raises(DataError, match="aam.safetensors is not the file that this speaker was made of"):
        SpeakerBundle.load(copy)
    # Somebody who mends the digests as well still does not get a model of another appearance model.
    about = json.loads((copy / "speaker.json").read_text())
    about["parts"]["aam"] = json.loads((other / "speaker.json").read_text())["parts"]["aam"]
    (copy / "speaker.json").write_text(json.dumps(about))
    with pytest.raises(DataError, match="trained for another appearance model"):
        SpeakerBundle.load(copy)


def test_folders_that_are_no_speaker(copy, tmp_path):
    with pytest.raises(StorageError, match="holds no speaker.json"):
        SpeakerBundle.load(tmp_path)
    about = json.loads((copy / "speaker.json").read_text())
    for text, said in [
        ("{", "speaker.json: it is no JSON"),
        ("{}", "does not describe"),
        (json.dumps([about]), "does not describe"),
        (json.dumps(about | {"parts": ["model"]}), "`parts` in its settings"),
        (json.dumps(about | {"phones": 40}), "`phones"),
        (json.dumps(about | {"phones": [1, *about["phones"]]}), "`phones"),
        (json.dumps(about | {"state_shares": {"aa": [0.5, 0.5]}}), "`state_shares"),
        (json.dumps(about | {"consent": None}), "`consent"),
        (json.dumps(about | {"version": 9}), "version 9"),
    ]:
        (copy / "speaker.json").write_text(text)
        with pytest.raises(StorageError, match=said):
            SpeakerBundle.load(copy)
    (copy / "speaker.json").write_text(json.dumps(about))
    (copy / FILES["head"]).unlink()
    with pytest.raises(StorageError, match="lacks head.safetensors"):
        SpeakerBundle.load(copy)


@pytest.mark.parametrize(
    ("part", "given", "said"),
    [
        ("model", "aam", "model.safetensors: it holds no trained model"),
        ("aam", "model", "aam.safetensors: it holds no appearance model"),
        ("reference", "model", "reference.safetensors: it holds no texture grid"),
        ("reference", "aam", "reference.safetensors: it holds no texture grid"),
        ("head", "model", "head.safetensors: it holds no head model"),
        ("rest", "model", "rest.safetensors: it holds no face at rest"),
        ("background", "model", "cannot read .*background.h5"),
    ],
)
def test_parts_of_another_kind_are_named(copy, part, given, said):
    """Digests alone would let through what somebody has put together by hand."""
    (copy / FILES[part]).write_bytes((copy / FILES[given]).read_bytes())
    about = json.loads((copy / "speaker.json").read_text())
    about["parts"][part] = about["parts"][given]
    (copy / "speaker.json").write_text(json.dumps(about))
    with pytest.raises(StorageError, match=said):
        SpeakerBundle.load(copy)


def signed(folder, part, change):
    """Change arrays and settings of a part of a speaker, with digests that fit again."""
    arrays, settings = read_model(folder / FILES[part])
    change(arrays, settings)
    write_model(folder / FILES[part], arrays, settings)
    about = json.loads((folder / "speaker.json").read_text())
    about["parts"][part] = file_digest(folder / FILES[part])
    (folder / "speaker.json").write_text(json.dumps(about))


def filled(name, value):
    return lambda arrays, settings: arrays[name].fill(value)


@pytest.mark.parametrize(
    ("part", "change", "said"),
    [
        (
            "model",
            filled("weights.output.bias", np.nan),
            "model.safetensors: the array 'weights.output.bias' has",
        ),
        ("model", filled("mean", np.inf), "model.safetensors: the array 'mean' has a value"),
        ("model", filled("scale", 1e30), "model.safetensors: the array 'scale' has a value"),
        ("rest", filled("appearance", np.nan), "rest.safetensors: the array 'appearance' has a value"),
        ("rest", filled("appearance", 1e8), "the face at rest lies far outside"),
        ("head", filled("centre", np.nan), "head.safetensors: the array 'centre' has a value"),
        ("head", filled("centre", 9e4), "the head in the background recordings lies far outside"),
        ("head", lambda arrays, settings: settings.update(focal=1e308), "`focal` in its settings"),
        ("head", lambda arrays, settings: settings.update(focal=None), "`focal` in its settings"),
        ("reference", filled("nearest", 2**31 - 1), "reference.safetensors: .*nearest"),
    ],
)
def test_numbers_that_are_no_face_are_refused(copy, part, change, said):
    signed(copy, part, change)
    with pytest.raises((StorageError, DataError), match=said) as error:
        SpeakerBundle.load(copy)
    assert str(copy) in str(error.value) and "ask for the folder again" in str(error.value)


def test_a_prediction_that_is_no_face_is_no_video(copy):
    signed(copy, "model", filled("scale", 1e8))
    bundle = SpeakerBundle.load(copy)
    with pytest.raises(StorageError, match="model.safetensors predicts what cannot be a face"):
        perform(speak_text("Hello."), bundle.trained, bundle.rest)


def test_a_background_of_another_appearance_model_is_refused(copy, tmp_path):
    other = speakers.make(tmp_path / "other", seed=5)
    (copy / FILES["background"]).write_bytes((other / FILES["background"]).read_bytes())
    about, theirs = (json.loads((folder / "speaker.json").read_text()) for folder in (copy, other))
    about["parts"]["background"] = theirs["parts"]["background"]
    (copy / "speaker.json").write_text(json.dumps(about))
    with pytest.raises(DataError, match="background.h5 is of another appearance model"):
        SpeakerBundle.load(copy)


def test_a_model_for_other_phones_is_refused(bundle):
    with pytest.raises(DataError, match="trained for other phones .*; zh in only one of them"):
        check_together(bundle.trained, bundle.speaker, bundle.trained.coding, PHONES[:-1])
    with pytest.raises(DataError, match="in another order"):
        check_together(bundle.trained, bundle.speaker, bundle.trained.coding, PHONES[::-1])


def test_pauses_are_at_rest_and_speech_is_not():
    alignment = timed([("sil", 0, 0.4), ("aa", 0.4, 0.8), ("sil", 0.8, 1.6), ("b", 1.6, 1.8), ("sil", 1.8, 2.4)])
    weight = pause_weights(alignment, 60, 25.0, 0.2)
    times = (np.arange(60) + 0.5) / 25
    speech = ((times > 0.4) & (times < 0.8)) | ((times > 1.6) & (times < 1.8))
    assert (weight[speech] == 0).all()
    assert (weight[(times < 0.2) | ((times > 1.01) & (times < 1.39)) | (times > 2.01)] == 1).all()
    assert np.abs(np.diff(weight)).max() < 0.35


def test_the_mouth_is_at_rest_in_silence(bundle):
    """Wherever nobody speaks for long the lips are as far apart as at rest, whatever the model says there."""
    performance = perform(speak_text("Mama. Papa and more."), bundle.trained, bundle.rest)
    aam = bundle.speaker.aam

    def opening(appearance):
        points = aam.points.region(aam.decode_points(np.atleast_2d(appearance)), "inner_lips")
        return points[:, 6, 1] - points[:, 2, 1]

    spoken = list(speak_text("Mama. Papa and more."))
    quiet, start = [], 0
    for one in spoken:
        frames = int(np.ceil(len(one.samples) / one.rate * 25 - 1e-6))
        quiet.append(pause_weights(one.alignment, frames, 25.0, REST) == 1)
        start += frames
    quiet = np.concatenate(quiet)
    assert len(quiet) == len(performance.appearance) and 10 < quiet.sum() < len(quiet)
    assert np.allclose(opening(performance.appearance[:][quiet]), opening(bundle.rest), atol=1e-3)
    assert np.abs(opening(performance.appearance[:][~quiet]) - opening(bundle.rest)).max() > 0.05


def test_sound_and_picture_are_of_one_length(bundle):
    texts = "One. Two three. Four five six. Seven."
    performance = perform(speak_text(texts, VoiceSettings(sentence_pause=0.3111)), bundle.trained, bundle.rest)
    assert performance.text == texts
    assert abs(len(performance.samples) / performance.audio_rate - performance.seconds) < 1e-3
    # The sound of each sentence is where its frames are: nothing is lost or moved by more than a frame a text.
    plain = np.concatenate([one.samples for one in speak_text(texts, VoiceSettings(sentence_pause=0.3111))])
    assert 0 <= len(performance.samples) - len(plain) <= 4 * performance.audio_rate / 25
    assert np.square(np.concatenate(list(performance.sound()))).sum() == pytest.approx(np.square(plain).sum(), rel=1e-4)


def test_a_network_of_richer_labels_speaks_too(bundle):
    parts = LabelParts(("position_in_syllable", "position_in_word", "stress"))
    blocks = {"tri": TriphoneState(PHONES), "parts": parts}
    rich = speakers.network(bundle.rest[None] * [[1.0], [1.1]], blocks, 25.0, "")
    performance = perform(speak_text("A happy map."), rich, bundle.rest)
    assert performance.appearance[:].shape[1] == bundle.trained.outputs


def test_phones_that_the_model_lacks_are_replaced_or_refused(bundle):
    alignment = timed([("sil", 0, 0.1), ("zh", 0.1, 0.2), ("oy", 0.2, 0.4)])
    renamed, replaced = in_phones(alignment, [phone for phone in PHONES if phone not in ("zh", "oy")])
    assert replaced == {"zh": "jh", "oy": "ao"}
    assert [phone.label for phone in renamed.phones] == ["sil", "jh", "ao"]
    assert in_phones(alignment, PHONES) == (alignment, {})
    with pytest.raises(SettingError, match="not those of the voice"):
        in_phones(alignment, ["SIL", "X"])


def test_a_scene_is_mixed_in_all_its_parts_alike(bundle):
    made = scene(bundle.background, 400)
    background = bundle.background
    mixed = next(i for i, mix in enumerate(made.mixes) if mix.share)
    frame, other, share = made.mixes[mixed]
    expected = (1 - share) * background.landmarks[frame] + share * background.landmarks[other]
    assert np.allclose(made.landmarks[mixed], expected, atol=1e-3)
    assert np.allclose(made.clips.sum(axis=1), 1)
    steps = np.linalg.norm(np.diff(made.landmarks[:, 27:31].mean(axis=1), axis=0), axis=1)
    recorded = [np.diff(background.landmarks[background.clip == i][:, 27:31].mean(axis=1), axis=0) for i in range(2)]
    assert steps.max() < 2 * max(np.linalg.norm(step, axis=1).max() for step in recorded)


def test_pictures_are_made_one_at_a_time(bundle):
    stream = speaking_frames(np.repeat(bundle.rest[None], 100_000, axis=0)[:3000], bundle)
    first = list(islice(stream, 3))
    assert len(first) == 3 and first[0].shape == (288, 360, 3)


def test_pictures_do_not_depend_on_how_many_are_placed_at_a_time(bundle, monkeypatch):
    """In pieces as in one, where the appearance has another rate than the pictures, from memory or from disk."""
    appearance = np.random.default_rng(2).normal(size=(200, len(bundle.rest))).astype(np.float32) * 3 + bundle.rest
    spool = Spool(np.float32, len(bundle.rest))
    spool.append(appearance)
    whole = list(speaking_frames(appearance, bundle, rate=100.0))
    monkeypatch.setattr(speaking, "_FRAMES_AT_A_TIME", 7)
    pieces = list(speaking_frames(spool, bundle, rate=100.0))
    assert len(whole) == len(pieces) == 50
    assert max(np.abs(a.astype(int) - b).max() for a, b in zip(whole, pieces, strict=True)) <= 1
    # By another route: the whole appearance brought to the pictures' rate first.
    resampled = list(speaking_frames(resample(appearance, 100.0, 25.0), bundle))
    assert max(np.abs(a.astype(int) - b).max() for a, b in zip(whole, resampled, strict=True)) <= 1


def test_the_video_has_sound_and_says_what_it_is(bundle, tmp_path):
    path = tmp_path / "out.mp4"
    performance = perform(speak_text("Hello."), bundle.trained, bundle.rest)
    speak(path, performance, bundle, "synthetic (test)")
    info = probe(path)
    assert info.rate == 25 and info.audio_rate == performance.audio_rate
    assert len(list(read_frames(path))) == len(performance.appearance)
    assert np.abs(read_audio(path, 16_000)).max() > 0.05
    with av.open(str(path)) as file:
        said = dict(file.metadata)
    assert "SYNTHETIC" in said["comment"] and "nobody" in said["comment"] and "Voice: synthetic" in said["comment"]
    assert (said["synthetic"], said["model"], said["corpus"], said["text"]) == ("yes", "F-4", "drawn", "Hello.")
    again = tmp_path / "again.mp4"
    speak(again, performance, bundle, "synthetic (test)")
    assert again.read_bytes() == path.read_bytes()


def test_the_label_can_be_left_out(bundle):
    rest = np.repeat(bundle.rest[None], 2, axis=0)
    with_label, without = (next(speaking_frames(rest, bundle, SpeakSettings(label=label))) for label in (True, False))
    assert np.abs(with_label.astype(int) - without)[-20:, -90:].max() > 60
    assert np.array_equal(with_label[:200], without[:200])


def test_what_cannot_be_shown(bundle):
    with pytest.raises(DataError, match="nothing to say"):
        perform([], bundle.trained, bundle.rest)
    one, other = (Spoken("a", np.zeros(rate, np.float32), rate, timed([("sil", 0, 1)])) for rate in (16_000, 22_050))
    with pytest.raises(DataError, match="16000 Hz, another of 22050"):
        perform([other, one], bundle.trained, bundle.rest)
