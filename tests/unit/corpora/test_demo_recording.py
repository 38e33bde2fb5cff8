"""Recordings of the demo speaker against their truth, and against the face tracker."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from visualspeech.corpora.demo.listing import utterances
from visualspeech.corpora.demo.recording import DemoSettings, read_truth, record, record_shard
from visualspeech.errors import SettingError, StorageError
from visualspeech.media.reading import probe, read_audio, read_frames
from visualspeech.storage.arrays import ArrayReader

UPPER, LOWER = [61, 62, 63], [67, 66, 65]


@pytest.fixture(scope="module")
def shard(tmp_path_factory):
    folder = tmp_path_factory.mktemp("demo")
    listed = utterances({"root": str(folder / "media"), "utterances": 2})
    record_shard(listed, folder / "media", folder / "truth" / "0.h5")
    with ArrayReader(folder / "truth" / "0.h5") as reader:
        yield listed, {name: read_truth(reader, name) for name in reader.ids}


def test_recordings_fit_their_truth(shard):
    listed, truths = shard
    assert sorted(truths) == [u.id for u in listed]
    for utterance in listed:
        truth, info = truths[utterance.id], probe(utterance.media)
        assert (info.rate, info.width, info.height, info.audio_rate) == (25.0, 320, 360, 22050)
        frames = sum(1 for _ in read_frames(utterance.media))
        assert frames == len(truth.points) == len(truth.parameters) == round(truth.duration * 25)
        assert 2 < truth.duration < 4.5
        assert truth.phones[0][1] == 0 and truth.phones[-1][2] == pytest.approx(truth.duration)
        assert all(a[2] == b[1] for a, b in zip(truth.phones, truth.phones[1:], strict=False))
        assert Path(utterance.media).with_suffix(".txt").read_text().strip() == utterance.transcript
        spoken = [word.strip(".,?!").lower() for word in utterance.transcript.split()]
        assert [word for word, *_ in truth.words] == spoken


def test_sound_is_quiet_before_the_first_and_after_the_last_phone(shard):
    for utterance in shard[0]:
        truth = shard[1][utterance.id]
        sound = read_audio(utterance.media, 16000)
        first, last = truth.phones[0][2], truth.phones[-1][1]
        assert first >= 0.18 and truth.duration - last >= 0.18
        quiet = np.concatenate([sound[: int((first - 0.07) * 16000)], sound[int((last + 0.02) * 16000) :]])
        speech = sound[int(first * 16000) : int(last * 16000)]
        assert quiet.std() < 0.002 < 0.03 < speech.std() and np.abs(speech).max() < 0.99


def test_the_same_recording_has_the_same_bytes(shard, tmp_path):
    utterance = shard[0][0]
    record(utterance, tmp_path / "again.mp4")
    # The title in the file is the utterance's id, so that another file name changes nothing.
    assert (tmp_path / "again.mp4").read_bytes() == Path(utterance.media).read_bytes()


def test_the_tracker_finds_one_face_and_follows_the_lips(shard):
    import cv2
    import dlib

    package = importlib.util.find_spec("face_recognition_models")
    model = Path(package.origin).parent / "models" / "shape_predictor_68_face_landmarks.dat"
    detector, predictor = dlib.get_frontal_face_detector(), dlib.shape_predictor(str(model))
    tracked, true = [], []
    for utterance in shard[0]:
        truth = shard[1][utterance.id]
        for index, frame in enumerate(read_frames(utterance.media)):
            if index % 4:
                continue
            faces = detector(frame)
            assert len(faces) == 1, (utterance.id, index)
            face = faces[0]
            large = cv2.resize(frame, None, fx=4, fy=4, interpolation=cv2.INTER_CUBIC)
            box = dlib.rectangle(*(4 * side for side in (face.left(), face.top(), face.right(), face.bottom())))
            points = np.array([(p.x, p.y) for p in predictor(large, box).parts()]) / 4 - 0.375
            tracked.append(points)
            true.append(truth.points[index])
    tracked, true = np.array(tracked), np.array(true)
    opening = [(p[:, LOWER, 1] - p[:, UPPER, 1]).mean(axis=1) for p in (tracked, true)]
    assert np.corrcoef(*opening)[0, 1] > 0.85
    # The tracker places some points elsewhere on a face than its makers named; what counts is that they move together.
    rigid = [*range(27, 36), 36, 39, 42, 45]
    offset = (tracked - true)[:, rigid]
    assert np.abs(offset.mean(axis=0)).max() < 9 and offset.std(axis=0).max() < 1.5


def test_the_face_is_nobodys(shard):
    """dlib's face descriptor calls faces closer than 0.6 one person; frames of one speaker lie within 0.3."""
    import cv2
    import dlib
    import skimage.data

    folder = Path(importlib.util.find_spec("face_recognition_models").origin).parent / "models"
    predictor = dlib.shape_predictor(str(folder / "shape_predictor_68_face_landmarks.dat"))
    describer = dlib.face_recognition_model_v1(str(folder / "dlib_face_recognition_resnet_model_v1.dat"))
    detector = dlib.get_frontal_face_detector()

    def described(picture):
        picture = np.ascontiguousarray(cv2.resize(picture, None, fx=2, fy=2, interpolation=cv2.INTER_CUBIC))
        return np.array(describer.compute_face_descriptor(picture, predictor(picture, detector(picture)[0])))

    photograph = described(skimage.data.astronaut()[:300, 60:360])
    frames = [described(frame) for frame in list(read_frames(shard[0][0].media))[::25]]
    assert min(np.linalg.norm(photograph - frame) for frame in frames) > 0.55


def test_settings_and_folders_that_cannot_be_used(tmp_path):
    with pytest.raises(SettingError, match="rate"):
        DemoSettings(rate=0)
    (tmp_path / "file").write_text("")
    with pytest.raises(StorageError):
        record_shard([], tmp_path / "media", tmp_path / "file" / "truth.h5")
