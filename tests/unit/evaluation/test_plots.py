"""Pictures: that they are made, repeat to the byte, and take what strangers call their files."""

import io

import numpy as np
import pandas
import pytest
from PIL import Image

from visualspeech.errors import DataError
from visualspeech.evaluation import plots


def picture(png: bytes) -> np.ndarray:
    assert png.startswith(b"\x89PNG")
    return np.asarray(Image.open(io.BytesIO(png)).convert("RGB"))


def curve(epochs: int, seed: int = 0):
    falling = np.exp(-np.arange(epochs) / 5) + np.random.default_rng(seed).uniform(0, 0.01, epochs)
    return pandas.DataFrame(
        {"epoch": range(1, epochs + 1), "train": falling, "validation": falling + 0.2, "seconds": 1.0}
    )


def test_one_parameter_with_the_boundaries_of_phones():
    """Offsets do not change the picture, another parameter does; a line stands where a phone begins."""
    generator = np.random.default_rng(2)
    true, flat = generator.normal(size=(50, 6)), np.zeros((50, 6))
    phones = [("sil", 0.0, 0.2), ("ah", 0.2, 0.5)]
    png = plots.parameter(true, {"B": flat, "C": true}, 100.0, phones, 5, title="u1: words")
    assert png == plots.parameter(true + 7, {"B": flat - 3, "C": true}, 100.0, phones, 5, title="u1: words")
    assert png != plots.parameter(true, {"B": flat, "C": true}, 100.0, phones, 4, title="u1: words")
    lines = (picture(png) == (0xC8, 0xC8, 0xC8)).all(axis=2).sum(axis=0)
    assert (lines > 100).sum() >= 1
    with pytest.raises(DataError, match="no parameter 7; the visual coding has 6"):
        plots.parameter(true, {}, 100.0, phones, 7)
    with pytest.raises(DataError, match="B predicts an array of shape"):
        plots.parameter(true, {"B": flat[1:]}, 100.0, phones, 1)


@pytest.mark.parametrize(
    "panels",
    [{}, {"": ["FBB-128"]}, {letters: [f"{letters}-{nodes}" for nodes in (1, 2, 3)] for letters in ("F", "BB")}],
)
def test_learning_curves(panels):
    curves = {title: {name: curve(9, seed) for seed, name in enumerate(names)} for title, names in panels.items()}
    image = picture(plots.learning_curves(curves))
    assert image.shape[0] > 200 and image.shape[1] > 800


def test_curves_of_a_network_that_never_learned():
    lost = pandas.DataFrame({"epoch": [1], "train": [np.nan], "validation": [np.nan]})
    picture(plots.learning_curves({"": {"F-1": lost, "F-2": curve(1)}}))


def test_trajectories_show_truth_prediction_and_phones():
    generator = np.random.default_rng(1)
    true = generator.normal(size=(50, 4))
    phones = [("sil", 0.0, 0.5), ("b", 0.5, 1.2), ("ah", 1.2, 2.4)]
    image = picture(plots.trajectories(true, {"FBB-128": true * 0.5}, 25.0, phones, count=3, title="utt"))
    for colour in (plots.TRUTH, plots.COLOURS[1]):
        wanted = [int(colour[place : place + 2], 16) for place in (1, 3, 5)]
        assert (np.abs(image.astype(int) - wanted).max(axis=2) < 10).sum() > 200
    plain = plots.trajectories(true, {}, 25.0)
    assert plain != plots.trajectories(true, {}, 25.0, phones)


def test_fewer_parameters_than_asked_for():
    picture(plots.trajectories(np.zeros((5, 2)), {}, 25.0, count=3))


def test_lengths_that_differ_are_named():
    with pytest.raises(DataError, match=r"FBB.*\(4, 2\).*\(5, 2\)"):
        plots.trajectories(np.zeros((5, 2)), {"FBB": np.zeros((4, 2))}, 25.0)


def test_names_are_text_and_no_formulas():
    name = "$\\frac{ _x% & <b> a transcript that goes on and on " + 20 * "and on "
    picture(plots.trajectories(np.zeros((5, 1)), {name[:40]: np.ones((5, 1))}, 25.0, [("$\\x", 0.0, 0.2)], title=name))
    picture(plots.learning_curves({"$\\frac": {"$\\frac{-128": curve(3)}}))


def test_mode_pictures():
    faces = np.random.default_rng(2).integers(0, 255, (2, 3, 20, 30, 3), dtype=np.uint8)
    image = picture(plots.mode_pictures(faces))
    assert image.shape[1] > image.shape[0]
    with pytest.raises(DataError, match="uint8"):
        plots.mode_pictures(faces.astype(float))
    with pytest.raises(DataError, match="modes, steps"):
        plots.mode_pictures(faces[0])


def test_same_bytes_whatever_the_user_has_set():
    import matplotlib

    first = plots.learning_curves({"": {"FBB-128": curve(4)}})
    with matplotlib.rc_context({"lines.linewidth": 9, "figure.facecolor": "red", "savefig.dpi": 30}):
        assert plots.learning_curves({"": {"FBB-128": curve(4)}}) == first
        assert matplotlib.rcParams["lines.linewidth"] == 9  # and the user's settings are left alone
