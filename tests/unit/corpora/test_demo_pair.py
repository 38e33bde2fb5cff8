"""Demo corpora with several speakers and emotions: what an emotion does, who differs how, and what stays as it was."""

import importlib.util
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from tests.paths import REPOSITORY
from visualspeech.corpora.demo import camera, mouth
from visualspeech.corpora.demo.characters import CHARACTERS, EMOTIONS, MOVEMENTS
from visualspeech.corpora.demo.deformation import Inverse, deformed
from visualspeech.corpora.demo.listing import utterances
from visualspeech.corpora.demo.motion import Motion
from visualspeech.corpora.demo.portrait import MIDDLE, neutral_points
from visualspeech.corpora.demo.recording import DemoSettings, character_of, read_truth, record_shard
from visualspeech.corpora.demo.rendering import Renderer, image_points
from visualspeech.corpora.records import LEGAL_ID, Utterance
from visualspeech.corpora.split import split_utterances
from visualspeech.errors import SettingError
from visualspeech.media.reading import read_audio, read_frames
from visualspeech.settings import read_yaml
from visualspeech.storage.arrays import ArrayReader

PAIR = read_yaml(REPOSITORY / "config" / "corpora" / "demo_pair.yaml") | {"root": "media", "shards": None}
BROWS, INNER_BROWS, CORNERS = range(17, 27), [21, 22], [48, 54]


def still(frames=1):
    return Motion(np.zeros((frames, 3)), np.zeros((frames, 3)), np.zeros(frames), np.ones((frames, 3)), 0.0)


def test_the_listing_is_stable_and_balanced():
    found = utterances(PAIR)
    assert found == utterances(PAIR) and [one.id for one in found] == sorted(one.id for one in found)
    assert [one.id for one in found[:3]] == ["alex01_anger", "alex02_neutral", "alex04_sadness"]
    assert all(LEGAL_ID.fullmatch(one.id) and one.media == f"media/{one.id}.mp4" for one in found)
    assert set(Counter((one.speaker, one.emotion) for one in found).values()) == {5}
    cells = Counter((one.speaker, one.emotion, one.split) for one in found)
    assert {split: cells["robin", "anger", split] for split in ("train", "validation", "test")} == {
        "train": 3, "validation": 1, "test": 1}  # fmt: skip
    assert len(cells) == 2 * 4 * 3
    assert split_utterances(found) == {one.id: one.split for one in found}


def test_no_sentence_tells_its_emotion_and_a_larger_corpus_contains_a_smaller_one():
    found = utterances(PAIR)
    by_sentence = {}
    for one in found:
        by_sentence.setdefault(one.transcript, set()).add(one.emotion)
    assert len(by_sentence) == 20 and all(len(emotions) == 2 for emotions in by_sentence.values())
    fewer = utterances(PAIR | {"utterances": 24})
    assert {one.id for one in fewer} < {one.id for one in found}
    few = utterances(PAIR | {"utterances": 12})
    assert {one.split for one in few} == {""}, "too few for every emotion in every part: split by the workflow"


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"speakers": ["alice"]}, "speakers.*alice.*robin"),
        ({"emotions": ["boredom"]}, "emotions.*boredom.*sadness"),
        ({"emotions": "anger"}, "emotions.*list"),
        ({"utterances": 49}, "utterances.*1 to 48"),
    ],
)
def test_bad_settings_name_their_key(changes, said):
    with pytest.raises(SettingError, match=said):
        utterances(PAIR | changes)


def test_the_schema_knows_the_speakers_and_emotions():
    schema = read_yaml(REPOSITORY / "workflow" / "schemas" / "corpus.schema.yaml")["properties"]
    assert schema["speakers"]["items"]["enum"] == list(CHARACTERS)
    assert schema["emotions"]["items"]["enum"] == list(EMOTIONS)


@pytest.mark.parametrize("emotion", EMOTIONS)
def test_what_is_drawn_lies_where_the_truth_says(emotion):
    """The renderer's inverse against the closed form of the displacements."""
    character, face = CHARACTERS["robin"], EMOTIONS[emotion].face
    points = np.random.default_rng(0).uniform([60, 90], [260, 290], (500, 2))
    assert (
        np.abs(Inverse(character.proportions)(deformed(points, character.proportions, face), face) - points).max() < 0.1
    )
    assert np.array_equal(Inverse(())(points, {}), points) and deformed(points, (), {}) is points


def test_faces_stay_symmetric():
    mirrored = [*range(16, -1, -1), *range(26, 16, -1)]
    for emotion in EMOTIONS.values():
        moved = deformed(neutral_points(), CHARACTERS["robin"].proportions, emotion.face)[:27]
        assert np.allclose(moved * [-1, 1] + [2 * MIDDLE, 0], moved[mirrored])


def test_the_demo_speaker_has_not_changed():
    """Block means of a frame of the corpus ``demo``, as they were when it had no other speakers."""
    parameters = np.array([9.5, 7.5, 0.4, 0.0, 0.0, 0.2])
    frame = Renderer().frame(parameters, still(), 0)
    blocks = frame.reshape(9, 40, 8, 40, 3).mean(axis=(1, 3, 4))
    assert np.abs(blocks - np.array(DEMO_BLOCKS)).max() < 0.6
    canonical, seen = image_points(parameters, still(), 0)
    assert np.array_equal(canonical, mouth.points(parameters))
    assert np.array_equal(seen, camera.project(canonical, np.zeros(3), np.zeros(3)))
    speaker = character_of(utterances({"root": "media"})[0])
    assert (speaker.voice, speaker.pitch, speaker.rate, speaker.proportions) == ("en-us", 0, 1.0, ())


DEMO_BLOCKS = [
    [138.5, 142.3, 140.3, 110.7, 107.7, 127.2, 125.6, 119.5],
    [145, 135.5, 47.4, 48.3, 46.8, 57.4, 118.8, 121.5],
    [149.6, 90.3, 37.5, 121.5, 150.9, 90.4, 68.3, 118.3],
    [150.9, 85.3, 73.8, 139.2, 152.9, 114.2, 66.2, 118.5],
    [144.3, 132.2, 122.1, 135, 162.9, 159.4, 115.6, 117.3],
    [131.6, 141.3, 135.9, 118.3, 139.8, 145.5, 121.2, 109.9],
    [123.3, 130.2, 127.6, 136.9, 159.3, 124, 112.8, 105.8],
    [115.9, 120.9, 120.2, 120.4, 115.4, 106.3, 106.9, 105.7],
    [89.7, 86.5, 69.6, 79.6, 87.7, 71.2, 78.1, 88.1],
]


@pytest.fixture(scope="module")
def shard(tmp_path_factory):
    """One sentence by both speakers with all emotions, recorded at 5 frames per second."""
    folder = tmp_path_factory.mktemp("pair")
    listed = [
        Utterance(f"{who}_{emotion}", who, "", "My brother moved the blue lamp.", emotion=emotion)
        for who in ("alex", "robin")
        for emotion in EMOTIONS
    ]
    record_shard(listed, folder, folder / "truth.h5", DemoSettings(rate=5))
    with ArrayReader(folder / "truth.h5") as reader:
        truths = {name: read_truth(reader, name) for name in reader.ids}
        assert reader.attributes("alex_anger")["expression_names"].split() == list(MOVEMENTS)
    return folder, truths


def pitch_of(samples, rate=16000):
    """Median fundamental frequency in Hz of loud frames, by autocorrelation."""
    found = []
    for start in range(0, len(samples) - 800, 320):
        frame = samples[start : start + 800] - samples[start : start + 800].mean()
        if frame.std() < 0.5 * samples.std():
            continue
        correlation = np.correlate(frame, frame, "full")[799:]
        lags = np.arange(rate // 400, rate // 60)
        best = lags[np.argmax(correlation[lags] / (800 - lags))]
        if correlation[best] > 0.4 * correlation[0]:
            found.append(rate / best)
    return float(np.median(found))


@pytest.mark.parametrize("who", ["alex", "robin"])
def test_emotions_move_brows_corners_and_cheeks(shard, who):
    truths = {emotion: shard[1][f"{who}_{emotion}"] for emotion in EMOTIONS}
    brows, inner, corners = (
        {emotion: truth.frontal[:, list(rows), 1].mean() for emotion, truth in truths.items()}
        for rows in (BROWS, INNER_BROWS, CORNERS)
    )
    # Rows of an image count down.
    assert brows["anger"] > brows["neutral"] + 2 > brows["happiness"] + 3
    assert inner["anger"] > inner["neutral"] + 4 and inner["sadness"] < inner["neutral"] - 2
    assert corners["happiness"] < corners["neutral"] - 2 and corners["sadness"] > corners["neutral"] + 1.5
    width = {emotion: np.ptp(truth.frontal[:, CORNERS, 0], axis=1).mean() for emotion, truth in truths.items()}
    assert width["happiness"] > width["neutral"] + 2
    cheeks = list(MOVEMENTS).index("cheeks")
    assert truths["happiness"].expression[:, cheeks].mean() > 0.5 > abs(truths["anger"].expression[:, cheeks]).max()
    assert all(truth.expression.shape == (len(truth.points), len(MOVEMENTS)) for truth in truths.values())


@pytest.mark.parametrize("who", ["alex", "robin"])
def test_emotions_change_the_voice(shard, who):
    sound = {emotion: read_audio(shard[0] / f"{who}_{emotion}.mp4", 16000) for emotion in EMOTIONS}
    pitch = {emotion: pitch_of(samples) for emotion, samples in sound.items()}
    assert pitch["happiness"] > 1.1 * pitch["neutral"] > 1.1 * 1.05 * pitch["sadness"]
    assert pitch["anger"] > 1.03 * pitch["neutral"]
    level = {emotion: samples.std() for emotion, samples in sound.items()}
    assert level["sadness"] < 0.7 * level["neutral"] < 0.8 * level["anger"]
    assert len(sound["sadness"]) > 1.08 * len(sound["neutral"]) > 1.08 * len(sound["anger"])
    assert max(np.abs(samples).max() for samples in sound.values()) < 0.98, "nothing is clipped"


def test_the_speakers_differ_in_face_and_voice(shard):
    alex, robin = (shard[1][f"{who}_neutral"].frontal.mean(axis=0) for who in ("alex", "robin"))

    def proportions(face):
        eyes = face[45, 0] - face[36, 0]
        return np.array([face[12, 0] - face[4, 0], face[8, 1] - face[27, 1], face[54, 0] - face[48, 0]]) / eyes

    assert (np.abs(proportions(robin) / proportions(alex) - 1) > 0.05).all()
    voices = [pitch_of(read_audio(shard[0] / f"{who}_neutral.mp4", 16000)) for who in ("alex", "robin")]
    assert voices[1] > 1.2 * voices[0]
    first, second = (next(read_frames(shard[0] / f"{who}_neutral.mp4")).astype(int) for who in ("alex", "robin"))
    assert np.abs(first - second).mean() > 15


def test_the_tracker_sees_each_face_and_its_emotion(shard):
    import cv2
    import dlib
    import skimage.data

    folder = Path(importlib.util.find_spec("face_recognition_models").origin).parent / "models"
    predictor = dlib.shape_predictor(str(folder / "shape_predictor_68_face_landmarks.dat"))
    describer = dlib.face_recognition_model_v1(str(folder / "dlib_face_recognition_resnet_model_v1.dat"))
    detector = dlib.get_frontal_face_detector()
    tracked, described = {}, {}
    for name in shard[1]:
        raised = []
        for frame in read_frames(shard[0] / f"{name}.mp4"):
            large = np.ascontiguousarray(cv2.resize(frame, None, fx=2, fy=2, interpolation=cv2.INTER_CUBIC))
            faces = detector(large)
            assert len(faces) == 1, name
            shape = predictor(large, faces[0])
            points = np.array([(p.x, p.y) for p in shape.parts()]) / 2
            eyes = points[36:48, 1].mean()
            raised.append([eyes - points[INNER_BROWS, 1].mean(), points[CORNERS, 1].mean() - points[33, 1]])
        tracked[name] = np.mean(raised, axis=0)
        described[name] = np.array(describer.compute_face_descriptor(large, shape))
    for who in ("alex", "robin"):
        brow, corner = ({emotion: tracked[f"{who}_{emotion}"][k] for emotion in EMOTIONS} for k in (0, 1))
        assert brow["anger"] < brow["neutral"] - 1.5 and brow["sadness"] > brow["neutral"] + 0.5
        assert corner["happiness"] < corner["neutral"] - 1 < corner["sadness"] - 1
    between = np.linalg.norm(described["alex_neutral"] - described["robin_neutral"])
    within = np.linalg.norm(described["robin_anger"] - described["robin_neutral"])
    assert 1.3 * within < between
    # dlib's face descriptor calls faces closer than 0.6 one person; the photograph's person is none of them.
    photograph = np.ascontiguousarray(cv2.resize(skimage.data.astronaut()[:300, 60:360], None, fx=2, fy=2))
    original = np.array(describer.compute_face_descriptor(photograph, predictor(photograph, detector(photograph)[0])))
    assert min(np.linalg.norm(original - one) for name, one in described.items() if "neutral" in name) > 0.5
