"""Eq. 16-19 against figures worked out by hand, and against a plain slow version of the printed sums."""

import numpy as np
import pytest

from visualspeech.errors import DataError, SettingError
from visualspeech.evaluation import metrics
from visualspeech.evaluation.metrics import FaceSequence


def faces(appearance, shape=None, texture=None, lips=None) -> FaceSequence:
    appearance = np.asarray(appearance, dtype=float)
    frames = len(appearance)
    return FaceSequence(
        appearance,
        np.zeros((frames, 1)) if shape is None else np.asarray(shape, dtype=float),
        np.zeros((frames, 1)) if texture is None else np.asarray(texture, dtype=float),
        np.zeros((frames, 20, 2)) if lips is None else np.asarray(lips, dtype=float),
    )


def random_faces(generator, frames: int, like: FaceSequence | None = None, noise: float = 1.0) -> FaceSequence:
    sizes = {"appearance": (7,), "shape": (5,), "texture": (9,), "lips": (20, 2)}
    drawn = {name: noise * generator.normal(size=(frames, *size)) for name, size in sizes.items()}
    return FaceSequence(
        **{name: values + (0 if like is None else getattr(like, name)) for name, values in drawn.items()}
    )


def test_root_mean_square_error_by_hand():
    # Frame 1: sqrt((3^2 + 4^2) / 2) = 5 / sqrt(2). Frame 2: 0. Frame 3: sqrt((1 + 1) / 2) = 1.
    true = np.array([[0.0, 0.0], [1.0, 2.0], [5.0, 5.0]])
    predicted = np.array([[3.0, 4.0], [1.0, 2.0], [4.0, 6.0]])
    np.testing.assert_allclose(metrics.frame_rmse(predicted, true), [5 / np.sqrt(2), 0.0, 1.0], rtol=1e-15)


def test_error_is_the_mean_of_roots_and_not_the_root_of_the_mean():
    true, predicted = np.zeros((2, 1)), np.array([[1.0], [3.0]])
    row = metrics.score("a", faces(predicted), faces(true))
    assert row["rmse_appearance"] == 2.0  # (1 + 3) / 2; the root of the mean square would be sqrt(5)


def test_correlation_by_hand():
    # Frame 1: opposite order, -1. Frame 2: any positive line, 1.
    # Frame 3: deviations (-1, 0, 1) and (0, -1, 1): 1 / (sqrt(2) sqrt(2)) = 0.5.
    true = np.array([[1.0, 2.0, 3.0], [1.0, 2.0, 4.0], [1.0, 2.0, 3.0]])
    predicted = np.array([[3.0, 2.0, 1.0], [12.0, 14.0, 18.0], [1.0, 0.0, 2.0]])
    np.testing.assert_allclose(metrics.frame_correlation(predicted, true), [-1.0, 1.0, 0.5], rtol=1e-14)


def test_correlation_agrees_with_numpy():
    generator = np.random.default_rng(1)
    predicted, true = generator.normal(size=(2, 30, 87)) + 1000
    expected = [np.corrcoef(one, other)[0, 1] for one, other in zip(predicted, true, strict=True)]
    np.testing.assert_allclose(metrics.frame_correlation(predicted, true), expected, rtol=1e-9)


def test_constant_vector_has_no_correlation_and_counts_as_nothing_gained():
    true = np.array([[1.0, 2.0, 4.0], [1.0, 2.0, 4.0]])
    predicted = np.array([[0.1, 0.1, 0.1], [1.0, 2.0, 4.0]])
    correlation = metrics.frame_correlation(predicted, true)
    assert np.isnan(correlation[0]) and correlation[1] == pytest.approx(1)
    row = metrics.score("a", faces(predicted), faces(true))
    assert row["corr_undefined"] == 1
    assert row["corr"] == pytest.approx(0.5)  # (0 + 1) / 2: the frame stays in the denominator


@pytest.mark.parametrize("value", [0.0, 0.1, 1e-30, 123456.789, np.float32(0.7)])
def test_constant_vectors_are_recognised_whatever_their_size(value):
    constant = np.full((1, 87), value)
    varying = np.arange(87.0)[None]
    assert np.isnan(metrics.frame_correlation(constant, varying)).all()
    assert np.isnan(metrics.frame_correlation(varying, constant)).all()


def test_one_dimension_has_no_correlation():
    row = metrics.score("a", faces([[1.0], [2.0]]), faces([[1.0], [3.0]]))
    assert (row["corr"], row["corr_undefined"]) == (0.0, 2)


def test_lip_distance_by_hand():
    lips = np.zeros((1, 20, 2))
    lips[0, 0] = (3.0, 4.0)  # 5 px
    lips[0, 1] = (0.0, 1.0)  # 1 px
    row = metrics.score("a", faces([[0.0, 1.0]], lips=lips), faces([[0.0, 1.0]]))
    assert row["lip_distance_px"] == pytest.approx(6 / 20)


def test_variance_kept_by_hand():
    # True scatter: dimension 1: 2 * 1^2 = 2, dimension 2: 2 * 2^2 = 8. Predicted: half the swing, so a quarter of it,
    # and an offset, which is no variance over time.
    true = np.array([[-1.0, -2.0], [1.0, 2.0]])
    row = metrics.score("a", faces(true / 2 + 7), faces(true))
    assert row["true_scatter"] == 10
    assert row["variance_kept"] == pytest.approx(0.25)


def test_corpus_figures_are_the_printed_sums():
    """A slow version: the loops of Eq. 16-19 over utterances k and frames t."""
    generator = np.random.default_rng(2)
    pairs = []
    for frames in (3, 11, 6):
        true = random_faces(generator, frames)
        pairs.append((random_faces(generator, frames, true, 0.6), true))
    table = metrics.score_table(metrics.score(f"u{k}", *pair) for k, pair in enumerate(pairs))

    frames = 0
    total = dict.fromkeys(("shape", "texture", "appearance", "corr", "lips"), 0.0)
    kept = there = 0.0
    for predicted, true in pairs:
        for t in range(len(true.appearance)):
            frames += 1
            for name in ("shape", "texture", "appearance"):
                difference = getattr(predicted, name)[t] - getattr(true, name)[t]
                total[name] += np.sqrt(np.linalg.norm(difference) ** 2 / len(difference))
            total["corr"] += np.corrcoef(predicted.appearance[t], true.appearance[t])[0, 1]
            total["lips"] += sum(np.hypot(*(predicted.lips[t, p] - true.lips[t, p])) for p in range(20)) / 20
        kept += len(true.appearance) * predicted.appearance.var(axis=0).sum()
        there += len(true.appearance) * true.appearance.var(axis=0).sum()
    for name in ("shape", "texture", "appearance"):
        assert metrics.corpus_figure(table, f"rmse_{name}") == pytest.approx(total[name] / frames, rel=1e-12)
    assert metrics.corpus_figure(table, "corr") == pytest.approx(total["corr"] / frames, rel=1e-12)
    assert metrics.corpus_figure(table, "lip_distance_px") == pytest.approx(total["lips"] / frames, rel=1e-12)
    assert metrics.corpus_figure(table, "variance_kept") == pytest.approx(kept / there, rel=1e-12)


def test_corpus_figure_weighs_frames_and_not_utterances():
    rows = [
        metrics.score("long", faces(np.zeros((9, 1))), faces(np.zeros((9, 1)))),
        metrics.score("short", faces([[10.0]]), faces([[0.0]])),
    ]
    assert metrics.corpus_figure(metrics.score_table(rows), "rmse_appearance") == pytest.approx(1.0)


def test_single_frame_has_no_variance_and_takes_no_part_in_it():
    true = np.array([[-1.0, 0.0], [1.0, 0.0]])
    rows = [metrics.score("a", faces(true), faces(true)), metrics.score("b", faces(true[:1]), faces(true[:1]))]
    table = metrics.score_table(rows)
    assert np.isnan(table["variance_kept"][1])
    assert metrics.corpus_figure(table, "variance_kept") == 1.0


def test_perfect_prediction():
    true = random_faces(np.random.default_rng(3), 5)
    row = metrics.score("a", true, true)
    assert [row[name] for name in ("rmse_shape", "rmse_texture", "rmse_appearance", "lip_distance_px")] == [0, 0, 0, 0]
    assert row["corr"] == pytest.approx(1) and row["variance_kept"] == pytest.approx(1)


def test_table_survives_storage(tmp_path):
    from visualspeech import storage

    generator = np.random.default_rng(4)
    true = random_faces(generator, 4)
    table = metrics.score_table(
        [metrics.score("007", random_faces(generator, 4), true), metrics.score("006", true, true)]
    )
    storage.write_table(tmp_path / "metrics.tsv", table)
    again = storage.read_table(tmp_path / "metrics.tsv")
    assert list(again["id"]) == ["006", "007"]
    for name in metrics.METRICS:
        assert metrics.corpus_figure(again, name) == metrics.corpus_figure(table, name)


def test_lip_points_follow_equation_1():
    shape = np.array([[0, 1, 2, 10, 11, 12]])  # x of three points, then y
    np.testing.assert_array_equal(metrics.lip_points(shape, [2, 0]), [[[2, 12], [0, 10]]])


def test_lengths_that_differ_are_named():
    with pytest.raises(DataError, match=r"utt.*\(3, 2\).*\(4, 2\)"):
        metrics.score("utt", faces(np.zeros((3, 2))), faces(np.zeros((4, 2))))
    with pytest.raises(DataError, match="shape has 2 frames, appearance 3"):
        metrics.score("utt", faces(np.zeros((3, 2)), np.zeros((2, 1))), faces(np.zeros((3, 2)), np.zeros((2, 1))))


def test_what_is_no_number_is_named():
    predicted = np.zeros((3, 2))
    predicted[1, 0] = np.nan
    with pytest.raises(DataError, match="predicted appearance of frame 1"):
        metrics.score("utt", faces(predicted), faces(np.zeros((3, 2))))


def test_unknown_metric_names_the_known_ones():
    with pytest.raises(SettingError, match="rmse_shap.*Known: rmse_shape, rmse_texture"):
        metrics.metric_named("rmse_shap")
