import av
import numpy as np
import pytest

from tests.synthetic import hum
from tests.unit.animation.faces import POINTS, draw
from tests.unit.face import heads
from visualspeech.animation.video import (
    Panel,
    Recording,
    Speaker,
    side_by_side,
    synthetic_frames,
    video_metadata,
    write_talking_head,
)
from visualspeech.animation.video_settings import VideoSettings
from visualspeech.corpora.records import Utterance
from visualspeech.errors import DataError
from visualspeech.face.aam.model import AamSettings, fit
from visualspeech.face.aam.reference import ReferenceSettings, fit_reference, sample_textures
from visualspeech.face.aam.rows import ArrayRows
from visualspeech.face.drift import FaceReference
from visualspeech.face.head import fit_head
from visualspeech.face.point_sets import to_vector
from visualspeech.face.pose import estimate, to_frontal
from visualspeech.media.encoding import write_video
from visualspeech.media.reading import probe, read_audio, read_frames


@pytest.fixture(scope="module")
def spoken(tmp_path_factory):
    """A recorded utterance, what was measured of it, its speaker, and its appearance parameters."""
    made = heads.record(20, seed=4, mouth=5)
    path = tmp_path_factory.mktemp("recordings") / "a.mp4"
    write_video(path, (draw(points) for points in made.points), 25.0, hum(0.8, 48000), 48000)
    head = fit_head(made.points, heads.SIZE)
    pose = estimate(made.points, head, rate=25.0)
    shapes = to_vector(POINTS.select(to_frontal(made.points, pose, head)))
    frontal = POINTS.select(to_frontal(made.points, pose, head))
    reference = fit_reference([frontal], POINTS, ReferenceSettings(texture_pixels=2000))
    textures = sample_textures(read_frames(path), POINTS.select(made.points), reference)
    components = {"components": 6}
    settings = AamSettings(shape=components, texture=components, appearance={"components": 8})
    zero = FaceReference(np.zeros(102, np.float32), np.zeros(textures.shape[1], np.float32))
    aam = fit(shapes, ArrayRows(textures.astype(np.float32)), POINTS, settings, zero)
    v = aam.encode(shapes, textures).appearance
    utterance = Utterance("a", "s1", str(path), "spoken words")
    return utterance, Recording(made.points, pose, zero), Speaker(head, aam, reference), v


def test_reconstruction_looks_like_the_recording(spoken):
    utterance, recording, speaker, v = spoken
    recorded = list(read_frames(utterance.media))
    rendered = list(synthetic_frames(iter(recorded), v, recording, speaker, rate=25.0))
    assert len(rendered) == len(recorded)
    for a, b in zip(recorded, rendered, strict=True):
        assert np.abs(a.astype(int) - b).mean() < 1.0


def test_the_drift_of_the_utterance_is_put_back(spoken):
    utterance, recording, speaker, v = spoken
    recorded = list(read_frames(utterance.media))
    plain = list(synthetic_frames(iter(recorded), v, recording, speaker, rate=25.0))
    up = np.zeros(102, np.float32)
    up[51 + 26 : 51 + 46] = 6  # the lips of this utterance lie 6 pixels lower
    seat = Recording(recording.landmarks, recording.pose, FaceReference(up, recording.drift.texture))
    moved = list(synthetic_frames(iter(recorded), v, seat, speaker, rate=25.0))

    def height_of_mouth(picture):
        return 140 + np.nonzero(picture[140:].max(axis=2) < 100)[0].mean()  # below the eyes only its inside is dark

    shift = [height_of_mouth(b) - height_of_mouth(a) for a, b in zip(plain, moved, strict=True)]
    assert np.mean(shift) == pytest.approx(6, abs=1)


def test_the_file_has_picture_and_sound_and_says_that_it_is_synthetic(spoken, tmp_path):
    utterance, recording, speaker, v = spoken
    path = tmp_path / "a.mp4"
    fast = np.repeat(v, 4, axis=0)
    streams = {"AAM reconstruction": (v, 25.0), "prediction": (fast, 100.0)}
    write_talking_head(path, utterance, recording, streams, speaker, "made up", "FBB-128", "Drawn; it is nobody.")
    frames = list(read_frames(path))
    assert len(frames) == 20
    assert frames[0].shape[1] == 3 * 360 and frames[0].shape[0] > 288
    info = probe(path)
    assert info.rate == 25 and info.audio_rate == 48000
    assert np.abs(read_audio(path, 16000)).max() > 0.05
    with av.open(str(path)) as file:
        said = dict(file.metadata)
    assert "synthetic" in said["title"] and "SYNTHETIC" in said["comment"]
    assert "FBB-128" in said["comment"] and "made up" in said["comment"] and "it is nobody" in said["comment"]
    assert (said["synthetic"], said["model"], said["corpus"]) == ("yes", "FBB-128", "made up")
    again = tmp_path / "b.mp4"
    write_talking_head(again, utterance, recording, streams, speaker, "made up", "FBB-128", "Drawn; it is nobody.")
    assert path.read_bytes() == again.read_bytes()


def test_the_label_can_be_switched_off(spoken, tmp_path):
    utterance, recording, speaker, v = spoken
    pictures = {}
    for label in (True, False):
        path = tmp_path / f"{label}.mp4"
        write_talking_head(
            path, utterance, recording, {"p": (v, 25.0)}, speaker, "c", "m", settings=VideoSettings(label=label)
        )
        pictures[label] = next(iter(read_frames(path))).astype(int)
    difference = np.abs(pictures[True] - pictures[False]).max(axis=2)
    assert difference[-20:, -90:].max() > 60  # on the synthetic panel
    assert difference[:, :350].max() < 25  # not on the original


def test_without_consent_the_file_says_so():
    assert "No statement of consent" in video_metadata("a", "c", "m", "  ")["comment"]


def test_panels_are_joined_frame_by_frame_to_even_sizes():
    taken = []

    def stream(name, width):
        for index in range(5):
            taken.append(name)
            yield np.full((33, width, 3), index, np.uint8)

    panels = [Panel("a", stream("a", 21), synthetic=False), Panel("b", stream("b", 30))]
    result = side_by_side(panels)
    first = next(result)
    assert taken == ["a", "b"]
    rest = list(result)
    assert len(rest) == 4
    for index, picture in enumerate([first, *rest]):
        assert picture.shape[0] % 2 == 0 and picture.shape[1] == 52
        assert np.all(picture[-8:-1, :21] == index)


def test_panels_that_do_not_fit_are_told():
    grey = np.zeros((32, 32, 3), np.uint8)
    with pytest.raises(DataError, match="'b' ends after 2"):
        list(side_by_side([Panel("a", [grey] * 3), Panel("b", [grey] * 2)]))
    with pytest.raises(DataError, match="height"):
        list(side_by_side([Panel("a", [grey]), Panel("b", [grey[:20]])]))
