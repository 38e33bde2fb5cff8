"""Measures by region of the face: by hand, and against plain slow versions of the printed formula."""

import numpy as np
import pytest

from visualspeech.errors import DataError
from visualspeech.evaluation import metrics
from visualspeech.evaluation.regions import region_scores, region_statistics
from visualspeech.evaluation.scoring import score_table
from visualspeech.evaluation.statistics import BootstrapSettings, draws, figure, sample, selected

REGIONS = {"upper": (0, 1, 2), "lower": (5, 3)}  # the middle is missing, one column belongs to none


def recordings(seed: int = 0, count: int = 6):
    """Predictions and truths (T, 6) of utterances of 2 frames and more, each with an offset of its own."""
    generator = np.random.default_rng(seed)
    pairs = []
    for number in range(count):
        true = generator.normal(size=(2 + 7 * number, 6)) + generator.normal(size=6)
        pairs.append((0.6 * true + 0.5 * generator.normal(size=true.shape) + 0.2, true))
    return pairs


def table_of(pairs, regions=REGIONS, drift_kept=True):
    return score_table(
        region_statistics(f"u{number}", x, y, 120.0, regions, drift_kept) for number, (x, y) in enumerate(pairs)
    )


def lin(x: np.ndarray, y: np.ndarray) -> float:
    """Eq. 1 of Sadoughi and Busso (2017) as printed, of two sequences, with scipy's Pearson correlation."""
    from scipy.stats import pearsonr

    rho, sx, sy = pearsonr(x, y).statistic, x.std(), y.std()
    return 2 * rho * sx * sy / (sx**2 + sy**2 + (x.mean() - y.mean()) ** 2)


def by_formula(pairs, columns, measure: str) -> float:
    x, y = (np.concatenate([pair[side] for pair in pairs])[:, list(columns)] for side in range(2))
    if measure == "mse":
        return np.square(x - y).mean()
    return np.mean([lin(x[:, i], y[:, i]) for i in range(x.shape[1])])


def centred(pairs):
    return [(x - x.mean(axis=0), y - y.mean(axis=0)) for x, y in pairs]


def test_a_hand_computed_case():
    """One parameter over two utterances: x = 0 2 | 1, y = 0 1 | 2."""
    table = table_of([([[0.0], [2.0]], [[0.0], [1.0]]), ([[1.0]], [[2.0]])], {"upper": (0,)})
    # Both have mean 1 and variance 2/3; their covariance is (0 + 2 + 2) / 3 - 1 = 1/3.
    assert metrics.corpus_figure(table, "ccc_upper_absolute") == pytest.approx(0.5)
    assert metrics.corpus_figure(table, "mse_upper_absolute") == pytest.approx((0 + 1 + 1) / 3)
    # Less the means of the utterances: x = -1 1 | 0, y = -.5 .5 | 0.
    assert metrics.corpus_figure(table, "ccc_upper") == pytest.approx(2 * 1 / (2 + 0.5))
    assert metrics.corpus_figure(table, "mse_upper") == pytest.approx(0.5 / 3)
    assert metrics.corpus_figure(table, "gv_ratio_upper") == pytest.approx(4)
    # Alone, the first has covariance .5, variances 1 and .25, means 1 and .5; the second, of one frame, is 0.
    assert metrics.corpus_figure(table, "ccc_upper_turn_absolute") == pytest.approx((2 * 0.5 / 1.5 + 0) / 2)
    assert metrics.corpus_figure(table, "mse_upper_turn_absolute") == pytest.approx((0.5 + 1) / 2)


@pytest.mark.parametrize("region", REGIONS)
@pytest.mark.parametrize("measure", ["ccc", "mse"])
def test_over_all_frames_as_one_sequence(region, measure):
    pairs, columns = recordings(), REGIONS[region]
    table = table_of(pairs)
    absolute = metrics.corpus_figure(table, f"{measure}_{region}_absolute")
    assert absolute == pytest.approx(by_formula(pairs, columns, measure), rel=1e-12)
    assert metrics.corpus_figure(table, f"{measure}_{region}") == pytest.approx(
        by_formula(centred(pairs), columns, measure), rel=1e-12
    )


@pytest.mark.parametrize("measure", ["ccc", "mse"])
def test_per_turn_and_mean_over_turns(measure):
    pairs = recordings(1)
    table = table_of(pairs)
    for ending, used in (("_absolute", pairs), ("", centred(pairs))):
        each = [by_formula([pair], REGIONS["lower"], measure) for pair in used]
        found = metrics.over_utterances(table, metrics.METRICS[f"{measure}_lower_turn{ending}"])
        assert metrics.corpus_figure(table, f"{measure}_lower_turn{ending}") == pytest.approx(np.mean(each))
        assert found == pytest.approx((np.mean(each), np.std(each, ddof=1)))


def test_the_coefficient_agrees_with_that_of_the_whole_vector():
    """The other implementation, from more sums."""
    from visualspeech.evaluation.scoring import _moments

    pairs = recordings(2)
    x, y = (np.concatenate([pair[side] for pair in pairs]) for side in range(2))
    moments = np.array([len(x), *_moments(x, y).values()])
    everything = {"middle": tuple(range(6))}
    assert metrics.corpus_figure(table_of(pairs, everything), "ccc_middle_absolute") == pytest.approx(
        float(metrics.concordance(moments))
    )


def test_a_constant_parameter_has_no_coefficient_and_is_left_out():
    true = np.array([[0.1, 1.0], [0.1, 3.0], [0.1, 2.0]])
    table = table_of([(true.copy(), true)], {"upper": (0, 1)})
    assert metrics.corpus_figure(table, "ccc_upper_absolute") == pytest.approx(1.0)
    alone = table_of([(true.copy(), true)], {"upper": (0,)})
    assert np.isnan(metrics.corpus_figure(alone, "ccc_upper_absolute"))
    assert np.isnan(metrics.corpus_figure(alone, "ccc_upper"))
    assert metrics.corpus_figure(alone, "ccc_upper_turn") == 0


def test_a_constant_prediction_has_no_agreement():
    """The training mean: its coefficient is 0 in both protocols, whatever its value."""
    pairs = [(np.full_like(y, 0.3), y) for _, y in recordings(3)]
    table = table_of(pairs)
    for name in ("ccc_upper", "ccc_upper_absolute", "ccc_upper_turn", "ccc_upper_turn_absolute"):
        assert metrics.corpus_figure(table, name) == pytest.approx(0, abs=1e-12)


def test_without_the_offset_of_the_truth_there_is_the_centred_protocol_alone():
    table = table_of(recordings(), drift_kept=False)
    kept = {name for name, metric in metrics.REGIONAL.items() if metrics.is_measured(table, metric)}
    assert kept == {
        name
        for name, metric in metrics.REGIONAL.items()
        if metric.protocol == metrics.CENTRED and metric.region in REGIONS
    }


def test_wide_statistics_are_summed_as_narrow_ones_are():
    generator = np.random.default_rng(0)
    values, chosen = generator.normal(size=(9, 40)), generator.integers(9, size=(3, 5, 7))
    slow = np.array([[values[one].sum(axis=0) for one in row] for row in chosen])
    np.testing.assert_allclose(selected(values, chosen), slow, rtol=1e-12)
    np.testing.assert_allclose(selected(values[:, :3], chosen), slow[..., :3], rtol=1e-12)
    np.testing.assert_allclose(selected(values, chosen[0, 0]), slow[0, 0], rtol=1e-12)


def test_an_interval_is_that_of_figures_computed_anew_on_drawn_utterances():
    pairs, settings = recordings(4), BootstrapSettings(samples=200, seed=3)
    drawn, metric = draws(len(pairs), settings), metrics.METRICS["ccc_upper_absolute"]
    slow = [by_formula([pairs[one] for one in row], REGIONS["upper"], "ccc") for row in drawn]
    found = figure(sample(table_of(pairs), metric, drawn), 0.9)
    assert (found.low, found.high) == pytest.approx(tuple(np.quantile(slow, [0.05, 0.95])))
    assert found.low < found.value < found.high


def test_bad_values_are_named():
    good = np.zeros((4, 6))
    bad = good.copy()
    bad[2, 1] = np.nan
    with pytest.raises(DataError, match="u7: the predicted appearance of frame 2 is not a finite number"):
        region_statistics("u7", bad, good, 25.0, REGIONS)
    with pytest.raises(DataError, match="u7: predicted appearance"):
        region_statistics("u7", good[:3], good, 25.0, REGIONS)
    with pytest.raises(DataError, match="0 frames"):
        region_statistics("u7", good[:0], good[:0], 25.0, REGIONS)


def test_scores_read_predictions_and_targets():
    class Files:
        def __init__(self, side):
            self.side = side

        def array(self, one, name):
            assert name == "appearance"
            return recordings()[int(one[1:])][self.side]

        def rate(self, one):
            return 120.0

    table = score_table(region_scores(["u1", "u0"], Files(0), Files(1), REGIONS))
    assert list(table["id"]) == ["u0", "u1"] and list(table["frames"]) == [2, 9]
    assert table.equals(table_of(recordings()[:2]))
