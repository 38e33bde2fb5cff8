"""The visual coding of markers: statistics by two routes, inverse, speakers, files that a stranger may have made."""

import numpy as np
import pytest

from visualspeech.errors import DamagedFile, DataError, StorageError
from visualspeech.face.coding_files import load_coding, read_coding_header
from visualspeech.face.marker_coding import MarkerCoding, MarkerSettings, fit
from visualspeech.face.markers import marker_set
from visualspeech.storage.models import read_model, write_model
from visualspeech.storage.regions import coding_regions

MARKERS = marker_set({"upper": ["brow"], "middle": ["nose"], "lower": ["lip", "chin"]}, "here")


def recordings(seed=1, dimensions=3):
    """Utterances of two speakers whose faces differ in place and movement."""
    random = np.random.default_rng(seed)
    places = {"anna": (100.0, 3.0), "ben": (-40.0, 0.5)}
    return [
        (name, (at + wide * random.normal(size=(frames, 4, dimensions))).astype(np.float32))
        for frames in (30, 7, 51)
        for name, (at, wide) in places.items()
    ]


def of(recorded, speaker):
    return np.concatenate([points for name, points in recorded if name == speaker]).astype(np.float64)


@pytest.fixture
def coding():
    return fit(recordings(), MARKERS, "mine")


def test_training_utterances_have_mean_0_and_deviation_1_per_speaker(coding):
    recorded = recordings()
    for speaker in ("anna", "ben"):
        coded = np.concatenate([coding.encode(points, speaker) for name, points in recorded if name == speaker])
        assert coded.shape == (88, 12) and coded.dtype == np.float32
        np.testing.assert_allclose(coded.mean(axis=0), 0, atol=2e-5)
        np.testing.assert_allclose(coded.std(axis=0), 1, atol=2e-5)
        np.testing.assert_allclose(
            coding._statistics(speaker)[0], of(recorded, speaker).mean(axis=0).ravel(), rtol=1e-6
        )
        np.testing.assert_allclose(coding._statistics(speaker)[1], of(recorded, speaker).std(axis=0).ravel(), rtol=1e-5)


def test_decoding_is_the_inverse(coding):
    for speaker, points in recordings(seed=2):
        again = coding.decode_points(coding.encode(points, speaker), speaker)
        np.testing.assert_allclose(again, points, atol=2e-5)
    # One speaker's values decode to another's face.
    assert abs(coding.decode_points(np.zeros((1, 12)), "ben").mean() + 40) < 1


@pytest.mark.parametrize("normalisation", ["speaker", "corpus"])
def test_unseen_speakers_have_the_statistics_of_all_frames_together(normalisation):
    recorded = recordings()
    coding = fit(recorded, MARKERS, settings=MarkerSettings(normalisation=normalisation))
    every = np.concatenate([points for _, points in recorded]).astype(np.float64)
    new = recordings(seed=3)[0][1]
    expected = ((new - every.mean(axis=0)) / every.std(axis=0)).reshape(len(new), -1)
    np.testing.assert_allclose(coding.encode(new, "carla"), expected, rtol=1e-4, atol=1e-5)
    assert (coding.speakers == ()) == (normalisation == "corpus")
    if normalisation == "corpus":
        np.testing.assert_array_equal(coding.encode(new, "anna"), coding.encode(new, "carla"))


def test_a_coordinate_that_does_not_move_is_centred_only():
    points = recordings()[0][1]
    points[:, 2, 1] = 5.0
    coding = fit([("anna", points)], MARKERS)
    coded = coding.encode(points, "anna")
    assert (coded[:, 2 * 3 + 1] == 0).all() and np.isfinite(coded).all()
    still = fit([("anna", np.ones((4, 4, 1), np.float32))], MARKERS)
    assert (still.deviation == 1).all()


def test_regions_are_columns_of_the_vectors(coding):
    assert coding.regions == {"upper": (0, 1, 2), "middle": (3, 4, 5), "lower": (6, 7, 8, 9, 10, 11)}
    points = np.zeros((1, 4, 3), np.float32)
    points[0, 3, 2] = 1  # chin, third coordinate
    moved = coding.encode(points, "anna") - coding.encode(np.zeros((1, 4, 3)), "anna")
    assert np.nonzero(moved[0])[0].tolist() == [11] and 11 in coding.regions["lower"]
    assert coding.size == 12 and coding.points is None


def test_a_saved_coding_is_the_same(coding, tmp_path):
    path = tmp_path / "model.safetensors"
    coding.save(path)
    again = load_coding(path)
    assert isinstance(again, MarkerCoding)
    for name in ("markers", "dimensions", "source", "speakers", "settings", "regions"):
        assert getattr(again, name) == getattr(coding, name)
    points = recordings(seed=4)[1][1]
    np.testing.assert_array_equal(again.encode(points, "ben"), coding.encode(points, "ben"))
    assert coding_regions(path) == coding.regions
    header = read_coding_header(path)
    assert header.kind == "markers" and header.points == "mine" and header.sizes == {"appearance": 12}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda arrays, plain: arrays.pop("mean"), "'mean' is missing"),
        (lambda arrays, plain: arrays.update(mean=arrays["mean"] * np.nan), "'mean' has a value"),
        (lambda arrays, plain: arrays.update(deviation=arrays["deviation"] * 0), "'deviation' has a value"),
        (lambda arrays, plain: arrays.update(mean=arrays["mean"][:2], deviation=arrays["deviation"][:2]), "shape"),
        (lambda arrays, plain: plain.update(speakers=["anna", "anna"]), "a speaker occurs twice"),
        (lambda arrays, plain: plain.update(dimensions=2), "not .3, 8."),
        (lambda arrays, plain: plain.update(dimensions=0), "`dimensions`"),
        (lambda arrays, plain: plain.update(names=["brow", "nose", "lip", "lip"]), "that it has not"),
        (lambda arrays, plain: plain.update(regions={"upper": ["brow"]}), "each marker must be in one region"),
        (lambda arrays, plain: plain.update(regions={"left": ["brow"]}), "left"),
        (lambda arrays, plain: plain["regions"].update(upper=["eye"]), "that it has not"),
        (lambda arrays, plain: plain.update(settings={"normalisation": "none"}), "another version"),
        (lambda arrays, plain: plain.update(kind="aam"), "no visual coding of markers"),
        (lambda arrays, plain: plain.pop("speakers"), "speakers"),
        (lambda arrays, plain: plain["columns"].update(upper=[0]), "columns of its regions"),
    ],
)
def test_hostile_files_are_refused_in_a_sentence(coding, tmp_path, change, said):
    path = tmp_path / "model.safetensors"
    coding.save(path)
    arrays, plain = read_model(path)
    change(arrays, plain)
    write_model(path, arrays, plain)
    with pytest.raises(StorageError, match=said) as error:
        MarkerCoding.load(path)
    assert str(path) in str(error.value)


def test_unknown_kinds_of_codings_are_named(coding, tmp_path):
    path = tmp_path / "model.safetensors"
    coding.save(path)
    arrays, plain = read_model(path)
    write_model(path, arrays, {**plain, "kind": "mesh"})
    with pytest.raises(DamagedFile, match="unknown kind 'mesh'; known are aam, markers"):
        load_coding(path)


def test_what_cannot_be_trained_on():
    points = recordings()[0][1]
    for recorded in ([], [("anna", points[:0])], [("anna", points * np.inf)], [("anna", points[:, :3])]):
        with pytest.raises(DataError):
            fit(recorded, MARKERS)
    with pytest.raises(DataError, match="4 markers of 3 coordinates"):
        fit([("anna", points), ("anna", points[..., :2])], MARKERS)
