"""Heads and screening per speaker."""

import numpy as np
import pytest

from tests.unit.face.heads import SIZE, record
from visualspeech.errors import CorpusError
from visualspeech.face.head import fit_head, load_heads
from visualspeech.face.pose import Pose, estimate, to_frontal
from visualspeech.face.sampling import fit_speaker_head, sample_landmarks
from visualspeech.face.speakers import screen_speakers
from visualspeech.storage.arrays import ArrayCollection, ArrayReader, ArrayWriter

SPEAKERS = {f"{speaker}{number:02d}": speaker for speaker in ("a", "b") for number in range(11)}
NOISE = {"a": 0.1, "b": 0.5}


@pytest.fixture(scope="module")
def corpus(tmp_path_factory):
    """Landmarks and poses of two speakers; ``a03`` is as noisy as all of ``b``, ``b05`` has frames of another size."""
    folder = tmp_path_factory.mktemp("corpus")
    with ArrayWriter(folder / "landmarks.h5") as out:
        for number, (one, speaker) in enumerate(SPEAKERS.items()):
            noise = NOISE["b"] if one == "a03" else NOISE[speaker]
            points = record(20, seed=20 + ord(speaker)).points
            points = points + np.random.default_rng(number).normal(0, noise, points.shape)
            size = (2 * SIZE[0], 2 * SIZE[1]) if speaker == "b" else SIZE
            size = SIZE if one == "b05" else size
            arrays = {"points": points, "detected": np.ones(20, bool)}
            out.add(one, arrays, 25.0, width=size[0], height=size[1])
    with ArrayCollection([folder / "landmarks.h5"]) as landmarks:
        for speaker in "ab":
            ids = [one for one in landmarks.ids if SPEAKERS[one] == speaker]
            fit_speaker_head(speaker, landmarks, ids).save(folder / f"{speaker}.safetensors")
        heads = load_heads("ab", [folder / "a.safetensors", folder / "b.safetensors"])
        with ArrayWriter(folder / "pose.h5") as out:
            for one in landmarks.ids:
                points, head = landmarks.array(one, "points"), heads[SPEAKERS[one]]
                pose = estimate(points, head, rate=25.0)
                arrays = {"rotation": pose.rotation, "translation": pose.translation}
                out.add(one, {**arrays, "points": to_frontal(points, pose, head)}, 25.0)
        with ArrayReader(folder / "pose.h5") as poses:
            yield landmarks, poses, heads


def test_a_head_is_fitted_to_the_speakers_own_utterances(corpus):
    landmarks, _, heads = corpus
    ids = [one for one in landmarks.ids if SPEAKERS[one] == "a"]
    points, size = sample_landmarks(landmarks, ids, heads["a"].settings.max_frames)
    np.testing.assert_array_equal(heads["a"].points3d, fit_head(points, size).points3d)
    assert heads["b"].centre.tolist() == [SIZE[0], SIZE[1]]
    with pytest.raises(CorpusError, match="speaker 'c'"):
        fit_speaker_head("c", landmarks, [])


def test_utterances_are_compared_with_those_of_their_speaker(corpus):
    landmarks, poses, heads = corpus
    refused = screen_speakers(landmarks, poses, heads, SPEAKERS, set(SPEAKERS))
    assert list(refused) == ["a03", "b05"]
    assert "nose and eyes move" in refused["a03"].reason
    assert "360x288 pixels, those of most utterances 720x576" in refused["b05"].reason


def test_poses_are_read_back(corpus):
    _, poses, _ = corpus
    pose = Pose.read(poses, "a00")
    np.testing.assert_array_equal(pose.rotation, poses.array("a00", "rotation"))
    np.testing.assert_array_equal(pose.translation, poses.array("a00", "translation"))
