"""Eq. 16-19 against figures worked out by hand, and against a plain slow version of the printed sums; CCC likewise."""

import numpy as np
import pytest

from visualspeech.errors import DataError, SettingError
from visualspeech.evaluation import metrics, scoring
from visualspeech.evaluation.scoring import FaceSequence


def faces(appearance, shape=None, texture=None, lips=None) -> FaceSequence:
    appearance = np.asarray(appearance, dtype=float)
    frames = len(appearance)
    return FaceSequence(
        appearance,
        np.zeros((frames, 1)) if shape is None else np.asarray(shape, dtype=float),
        np.zeros((frames, 1)) if texture is None else np.asarray(texture, dtype=float),
        np.zeros((frames, 20, 2)) if lips is None else np.asarray(lips, dtype=float),
    )


def score(predicted: FaceSequence, true: FaceSequence, name: str = "a", offset=0.0) -> dict:
    """Statistics of an utterance whose drift was kept, and its figures under the names of the measures."""
    row = scoring.score(name, predicted, true, 25.0, offset, drift_kept=True)
    table = scoring.score_table([row])
    return row | {name: metrics.corpus_figure(table, name) for name in metrics.METRICS if name not in metrics.REGIONAL}


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
    np.testing.assert_allclose(scoring.frame_rmse(predicted, true), [5 / np.sqrt(2), 0.0, 1.0], rtol=1e-15)


def test_error_is_the_mean_of_roots_and_not_the_root_of_the_mean():
    true, predicted = np.zeros((2, 1)), np.array([[1.0], [3.0]])
    row = score(faces(predicted), faces(true))
    assert row["rmse_appearance_absolute"] == 2.0  # (1 + 3) / 2; the root of the mean square would be sqrt(5)
    assert row["rmse_appearance"] == 1.0  # less the mean error of 2: -1 and 1


def test_correlation_by_hand():
    # Frame 1: opposite order, -1. Frame 2: any positive line, 1.
    # Frame 3: deviations (-1, 0, 1) and (0, -1, 1): 1 / (sqrt(2) sqrt(2)) = 0.5.
    true = np.array([[1.0, 2.0, 3.0], [1.0, 2.0, 4.0], [1.0, 2.0, 3.0]])
    predicted = np.array([[3.0, 2.0, 1.0], [12.0, 14.0, 18.0], [1.0, 0.0, 2.0]])
    np.testing.assert_allclose(scoring.frame_correlation(predicted, true), [-1.0, 1.0, 0.5], rtol=1e-14)


def test_the_first_five_dimensions_over_time_as_scipy_says():
    """Thangthai et al. (2016), section 5: averaged over five coefficients and then over utterances."""
    from scipy.stats import pearsonr

    generator = np.random.default_rng(5)
    pairs = []
    for frames in (12, 40):
        true = random_faces(generator, frames)
        pairs.append((random_faces(generator, frames, like=true, noise=0.7), true))
    table = scoring.score_table(scoring.score(f"u{i}", *pair, 25.0, drift_kept=True) for i, pair in enumerate(pairs))
    correlation, error, absolute = [], [], []
    for predicted, true in pairs:
        x, y = predicted.appearance[:, :5], true.appearance[:, :5]
        correlation.append(np.mean([pearsonr(x[:, i], y[:, i]).statistic for i in range(5)]))
        error.append(np.mean([np.std(x[:, i] - y[:, i]) for i in range(5)]))
        absolute.append(np.mean([np.sqrt(np.mean((x[:, i] - y[:, i]) ** 2)) for i in range(5)]))
    expected = {"corr_first5": correlation, "rmse_first5": error, "rmse_first5_absolute": absolute}
    for name, each in expected.items():
        assert metrics.corpus_figure(table, name) == pytest.approx(np.mean(each), rel=1e-12)
        found = metrics.over_utterances(table, metrics.METRICS[name])
        assert found == pytest.approx((np.mean(each), np.std(each, ddof=1)), rel=1e-12)


def test_a_constant_dimension_correlates_with_nothing_over_time():
    true = random_faces(np.random.default_rng(6), 20)
    predicted = FaceSequence(np.full((20, 7), 3.0), true.shape, true.texture, true.lips)
    row = score(predicted, true)
    assert row["corr_first5"] == 0 and row["rmse_first5"] == pytest.approx(true.appearance[:, :5].std(axis=0).mean())
    half = np.where(np.arange(7) % 2, 3.0, true.appearance)
    assert score(FaceSequence(half, true.shape, true.texture, true.lips), true)["corr_first5"] == pytest.approx(3 / 5)


def test_of_one_utterance_there_is_no_deviation():
    true = random_faces(np.random.default_rng(7), 20)
    table = scoring.score_table([scoring.score("a", true, true, 25.0)])
    mean, deviation = metrics.over_utterances(table, metrics.METRICS["corr_first5"])
    assert mean == pytest.approx(1) and np.isnan(deviation)


def test_correlation_agrees_with_numpy():
    generator = np.random.default_rng(1)
    predicted, true = generator.normal(size=(2, 30, 87)) + 1000
    expected = [np.corrcoef(one, other)[0, 1] for one, other in zip(predicted, true, strict=True)]
    np.testing.assert_allclose(scoring.frame_correlation(predicted, true), expected, rtol=1e-9)


def test_constant_vector_has_no_correlation_and_counts_as_nothing_gained():
    true = np.array([[1.0, 2.0, 4.0], [1.0, 2.0, 4.0]])
    predicted = np.array([[0.1, 0.1, 0.1], [1.0, 2.0, 4.0]])
    correlation = scoring.frame_correlation(predicted, true)
    assert np.isnan(correlation[0]) and correlation[1] == pytest.approx(1)
    row = score(faces(predicted), faces(true))
    assert row["corr_absolute"] == pytest.approx(0.5)  # (0 + 1) / 2: the frame stays in the denominator
    # A constant face does not move, whatever it is: nothing is left of it when it is centred.
    row = score(faces(np.full((3, 3), 0.1) * [1, 7, 30]), faces(np.random.default_rng(8).normal(size=(3, 3))))
    assert (row["corr_undefined"], row["corr"]) == (3, 0.0)


@pytest.mark.parametrize("value", [0.0, 0.1, 1e-30, 123456.789, np.float32(0.7)])
def test_constant_vectors_are_recognised_whatever_their_size(value):
    constant = np.full((1, 87), value)
    varying = np.arange(87.0)[None]
    assert np.isnan(scoring.frame_correlation(constant, varying)).all()
    assert np.isnan(scoring.frame_correlation(varying, constant)).all()


def test_one_dimension_has_no_correlation():
    row = score(faces([[1.0], [2.0]]), faces([[1.0], [3.0]]))
    assert (row["corr"], row["corr_absolute"], row["corr_undefined"]) == (0.0, 0.0, 2)


def test_lip_distance_by_hand():
    lips = np.zeros((1, 20, 2))
    lips[0, 0] = (3.0, 4.0)  # 5 px
    lips[0, 1] = (0.0, 1.0)  # 1 px
    row = score(faces([[0.0, 1.0]], lips=lips), faces([[0.0, 1.0]]))
    assert row["lip_distance_px_absolute"] == pytest.approx(6 / 20)
    assert row["lip_distance_px"] == 0.0  # of one frame, nothing is left when it is centred


def test_offset_of_a_recording_counts_in_the_absolute_protocol_alone():
    generator = np.random.default_rng(12)
    true = random_faces(generator, 9)
    offset = np.broadcast_to([3.0, 4.0], (20, 2))
    row = score(true, true, offset=offset)
    assert row["lip_distance_px_absolute"] == pytest.approx(5.0) and row["lip_distance_px"] == 0.0
    moved = FaceSequence(true.appearance + 2.0, true.shape - 1.0, true.texture, true.lips + offset)
    row = score(moved, true, offset=offset)
    assert row["lip_distance_px_absolute"] == pytest.approx(0.0, abs=1e-12)
    assert row["rmse_appearance"] == pytest.approx(0.0, abs=1e-12)
    assert row["rmse_appearance_absolute"] == pytest.approx(2.0) and row["rmse_shape_absolute"] == pytest.approx(1.0)


def test_centred_figures_are_those_of_sequences_less_their_means():
    generator = np.random.default_rng(13)
    true = random_faces(generator, 15)
    predicted = random_faces(generator, 15, true, 0.6)
    row = score(predicted, true)
    less = [
        FaceSequence(**{n: getattr(one, n) - getattr(one, n).mean(axis=0) for n in vars(one)})
        for one in (predicted, true)
    ]
    again = score(*less)
    for name in ("rmse_shape", "rmse_texture", "rmse_appearance", "corr", "lip_distance_px", "ccc"):
        assert row[name] == pytest.approx(again[f"{name}_absolute"], rel=1e-10)
        assert row[name] != pytest.approx(row[f"{name}_absolute"], rel=1e-3)


def test_parameters_have_no_absolute_error_where_drift_was_removed():
    true = random_faces(np.random.default_rng(14), 4)
    table = scoring.score_table([scoring.score("a", true, true, 25.0)])
    measured = {name for name, metric in metrics.METRICS.items() if metrics.is_measured(table, metric)}
    others = {name: metric for name, metric in metrics.METRICS.items() if not metric.region}
    centred = {name for name, metric in others.items() if metric.protocol == metrics.CENTRED}
    assert measured == centred | {"lip_distance_px_absolute"}


def test_global_variance_ratio_by_hand():
    # True scatter: dimension 1: 2 * 1^2 = 2, dimension 2: 2 * 2^2 = 8. Predicted: half the swing, so a quarter of it,
    # and an offset, which is no variance over time.
    true = np.array([[-1.0, -2.0], [1.0, 2.0]])
    row = score(faces(true / 2 + 7), faces(true))
    assert row["true_scatter"] == 10
    assert row["gv_ratio"] == pytest.approx(0.25)


def test_corpus_figures_are_the_printed_sums():
    """A slow version: the loops of Eq. 16-19 over utterances k and frames t."""
    generator = np.random.default_rng(2)
    pairs = []
    for frames in (3, 11, 6):
        true = random_faces(generator, frames)
        pairs.append((random_faces(generator, frames, true, 0.6), true))
    table = scoring.score_table(scoring.score(f"u{k}", *pair, 25.0, drift_kept=True) for k, pair in enumerate(pairs))

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
        assert metrics.corpus_figure(table, f"rmse_{name}_absolute") == pytest.approx(total[name] / frames, rel=1e-12)
    assert metrics.corpus_figure(table, "corr_absolute") == pytest.approx(total["corr"] / frames, rel=1e-12)
    assert metrics.corpus_figure(table, "lip_distance_px_absolute") == pytest.approx(total["lips"] / frames, rel=1e-12)
    assert metrics.corpus_figure(table, "gv_ratio") == pytest.approx(kept / there, rel=1e-12)


def test_corpus_figure_weighs_frames_and_not_utterances():
    rows = [
        scoring.score("long", faces(np.zeros((8, 1))), faces(np.zeros((8, 1))), 25.0),
        scoring.score("short", faces([[5.0], [-5.0]]), faces([[0.0], [0.0]]), 25.0),
    ]
    assert metrics.corpus_figure(scoring.score_table(rows), "rmse_appearance") == pytest.approx(1.0)


def test_single_frame_has_no_variance_and_takes_no_part_in_it():
    true = np.array([[-1.0, 0.0], [1.0, 0.0]])
    pairs = {"a": faces(true), "b": faces(true[:1])}
    table = scoring.score_table([scoring.score(name, each, each, 25.0) for name, each in pairs.items()])
    assert np.isnan(metrics.corpus_figure(table[1:], "gv_ratio"))
    assert metrics.corpus_figure(table, "gv_ratio") == 1.0


def test_perfect_prediction():
    true = random_faces(np.random.default_rng(3), 5)
    row = score(true, true)
    assert [row[name] for name in ("rmse_shape", "rmse_texture", "rmse_appearance", "lip_distance_px")] == [0, 0, 0, 0]
    assert row["corr"] == pytest.approx(1) and row["gv_ratio"] == pytest.approx(1)


def test_table_survives_storage(tmp_path):
    from visualspeech.storage.tables import read_table, write_table

    generator = np.random.default_rng(4)
    true = random_faces(generator, 4)
    table = scoring.score_table(
        [scoring.score("007", random_faces(generator, 4), true, 25.0), scoring.score("006", true, true, 25.0)]
    )
    write_table(tmp_path / "statistics.tsv", table)
    again = read_table(tmp_path / "statistics.tsv")
    assert list(again["id"]) == ["006", "007"]
    for name in metrics.METRICS:
        if not metrics.is_measured(table, metrics.METRICS[name]):
            continue
        assert metrics.corpus_figure(again, name) == metrics.corpus_figure(table, name)


def test_lip_points_follow_equation_1():
    shape = np.array([[0, 1, 2, 10, 11, 12]])  # x of three points, then y
    np.testing.assert_array_equal(scoring.lip_points(shape, [2, 0]), [[[2, 12], [0, 10]]])


def test_lengths_that_differ_are_named():
    with pytest.raises(DataError, match=r"utt.*\(3, 2\).*\(4, 2\)"):
        scoring.score("utt", faces(np.zeros((3, 2))), faces(np.zeros((4, 2))), 25.0)
    with pytest.raises(DataError, match="shape has 2 frames, appearance 3"):
        scoring.score("utt", faces(np.zeros((3, 2)), np.zeros((2, 1))), faces(np.zeros((3, 2)), np.zeros((2, 1))), 25.0)


def test_what_is_no_number_is_named():
    predicted = np.zeros((3, 2))
    predicted[1, 0] = np.nan
    with pytest.raises(DataError, match="predicted appearance of frame 1"):
        scoring.score("utt", faces(predicted), faces(np.zeros((3, 2))), 25.0)


def test_unknown_metric_names_the_known_ones():
    with pytest.raises(SettingError, match="rmse_shap.*Known: rmse_shape, rmse_texture"):
        metrics.metric_named("rmse_shap")


def old_figure(rows: list[tuple[float, float]]) -> float:
    """A figure as it was once computed: each utterance's mean, weighted with its frames or its scatter."""
    value, weight = np.array(rows).T
    numerator = np.where(weight > 0, np.nan_to_num(value) * weight, 0.0)
    return float(numerator.sum() / weight.sum())


def test_figures_are_the_same_to_the_last_bit_as_means_with_weights():
    generator = np.random.default_rng(11)
    trues = [random_faces(generator, frames) for frames in generator.integers(1, 90, 60)]
    pairs = [(random_faces(generator, len(true.lips), true, 0.7), true) for true in trues]
    table = scoring.score_table(
        scoring.score(f"u{k:02d}", *pair, 25.0, drift_kept=True) for k, pair in enumerate(pairs)
    )
    frames = [len(true.lips) for _, true in pairs]
    for name in ("shape", "texture", "appearance"):
        means = [scoring.frame_rmse(getattr(one, name), getattr(other, name)).mean() for one, other in pairs]
        assert metrics.corpus_figure(table, f"rmse_{name}_absolute") == old_figure(
            list(zip(means, frames, strict=True))
        )
    means = [np.nan_to_num(scoring.frame_correlation(one.appearance, other.appearance)).mean() for one, other in pairs]
    assert metrics.corpus_figure(table, "corr_absolute") == old_figure(list(zip(means, frames, strict=True)))
    means = [scoring.frame_point_distance(one.lips, other.lips).mean() for one, other in pairs]
    assert metrics.corpus_figure(table, "lip_distance_px_absolute") == old_figure(list(zip(means, frames, strict=True)))
    scatters = [[scoring.scatter_over_time(each.appearance) for each in pair] for pair in pairs]
    rows = [(kept / there if there > 0 else np.nan, there) for kept, there in scatters]
    assert metrics.corpus_figure(table, "gv_ratio") == old_figure(rows)


def slow_concordance(predicted: np.ndarray, true: np.ndarray) -> float:
    """Lin's coefficient of each dimension over all frames, from deviations and numpy's correlation; their mean."""
    found = []
    for x, y in zip(predicted.T, true.T, strict=True):
        correlation = np.corrcoef(x, y)[0, 1]
        found.append(2 * correlation * x.std() * y.std() / (x.var() + y.var() + (x.mean() - y.mean()) ** 2))
    return float(np.mean(found))


def ccc(pairs) -> float:
    rows = (
        scoring.score(f"u{k}", faces(one), faces(other), 25.0, drift_kept=True) for k, (one, other) in enumerate(pairs)
    )
    return metrics.corpus_figure(scoring.score_table(rows), "ccc_absolute")


def random_pairs(seed: int, dimensions: int = 11):
    generator = np.random.default_rng(seed)
    trues = [generator.normal(size=(frames, dimensions)) + generator.normal(size=dimensions) for frames in (5, 40, 13)]
    return [(0.6 * true + 0.4 * generator.normal(size=true.shape), true) for true in trues]


@pytest.mark.parametrize("seed", range(3))
def test_concordance_agrees_with_a_slow_version(seed):
    pairs = random_pairs(seed)
    whole = [np.concatenate(values) for values in zip(*pairs, strict=True)]
    assert ccc(pairs) == pytest.approx(slow_concordance(*whole), rel=1e-10)


def test_concordance_by_hand():
    # x = (0, 2), y = (1, 3): covariance 1, variances 1 and 1, means 1 apart: 2 / (1 + 1 + 1).
    assert ccc([([[0.0], [2.0]], [[1.0], [3.0]])]) == pytest.approx(2 / 3)


def test_concordance_is_of_the_corpus_and_not_a_mean_over_utterances():
    pairs = random_pairs(4)
    whole = [tuple(np.concatenate(values) for values in zip(*pairs, strict=True))]
    cut = [(one[start : start + 7], other[start : start + 7]) for one, other in whole for start in range(0, 58, 7)]
    assert ccc(cut) == pytest.approx(ccc(whole), rel=1e-12)
    assert ccc(whole) != pytest.approx(np.mean([ccc([pair]) for pair in pairs]), rel=1e-3)


def test_concordance_does_not_depend_on_offset_scale_and_order():
    pairs = random_pairs(5)
    scale, offset = np.linspace(0.1, 30, 11), np.linspace(-100, 100, 11)
    assert ccc([(scale * one + offset, scale * other + offset) for one, other in pairs]) == pytest.approx(ccc(pairs))
    assert ccc([(other, one) for one, other in pairs]) == pytest.approx(ccc(pairs))
    assert ccc([(other, other) for _, other in pairs]) == pytest.approx(1)
    assert ccc([(-other + 2 * other.mean(axis=0), other) for _, other in pairs[:1]]) == pytest.approx(-1)
    mean = np.concatenate([other for _, other in pairs]).mean(axis=0)
    assert ccc([(np.tile(mean, (len(other), 1)), other) for _, other in pairs]) == pytest.approx(0, abs=1e-12)


def test_concordance_leaves_out_dimensions_without_any_spread():
    still = np.full((6, 1), 2.0)
    true = np.random.default_rng(6).normal(size=(6, 1))
    both = [(np.hstack([true * 0.5, still]), np.hstack([true, still]))]
    assert ccc(both) == pytest.approx(ccc([(true * 0.5, true)]))
    assert np.isnan(ccc([(still, still)]))


def test_cost_is_lower_where_a_figure_is_better():
    better = {"rmse_shape": (0.5, 0.6), "corr": (0.7, 0.6), "ccc": (0.7, 0.6), "gv_ratio": (1.1, 0.8)}
    for name, (good, bad) in better.items():
        assert metrics.METRICS[name].cost(good) < metrics.METRICS[name].cost(bad)


def test_a_missing_column_is_named():
    table = scoring.score_table([scoring.score("a", faces(np.eye(3)), faces(np.eye(3)), 25.0)])
    lacking = table.drop(columns=["true.0", "true.1", "true.2"])
    assert metrics.is_measured(table, metrics.METRICS["ccc"])
    assert not metrics.is_measured(lacking, metrics.METRICS["ccc"])
    with pytest.raises(DataError, match="`true`, which `ccc` needs"):
        metrics.corpus_figure(lacking, "ccc")
