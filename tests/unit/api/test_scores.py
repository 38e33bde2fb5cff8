"""Scores of arrays against the formulas of the papers, and mistakes."""

import numpy as np
import pytest

from visualspeech import DataError, score


def utterances(seed=0, lengths=(40, 25), size=7):
    rng = np.random.default_rng(seed)
    true = {f"u{number}": rng.normal(size=(length, size)) + 3 * number for number, length in enumerate(lengths)}
    return {name: 0.5 * values + rng.normal(size=values.shape) for name, values in true.items()}, true


def test_the_figures_are_those_of_the_formulas():
    predicted, true = utterances()
    pairs = [[values - values.mean(axis=0) for values in (predicted[name], true[name])] for name in true]
    rmse = np.concatenate([np.sqrt(((x - y) ** 2).mean(axis=1)) for x, y in pairs])
    corr = [np.corrcoef(a, b)[0, 1] for x, y in pairs for a, b in zip(x, y, strict=True)]
    kept = sum((x**2).sum() for x, _ in pairs) / sum((y**2).sum() for _, y in pairs)
    x, y = (np.concatenate(part) for part in zip(*pairs, strict=True))
    ccc = 2 * (x * y).mean(axis=0) / ((x * x).mean(axis=0) + (y * y).mean(axis=0))
    found = score(predicted, true)
    assert found["rmse_appearance"] == pytest.approx(rmse.mean())
    assert found["corr"] == pytest.approx(np.mean(corr))
    assert found["gv_ratio"] == pytest.approx(kept)
    assert found["ccc"] == pytest.approx(ccc.mean())


def test_each_utterance_by_itself():
    predicted, true = utterances()
    table = score(predicted, true, by_utterance=True)
    assert list(table.index) == ["u0", "u1"]
    for name in true:
        alone = score(predicted[name], true[name])
        assert alone == pytest.approx(table.loc[name].to_dict())
        assert alone == pytest.approx(score({name: predicted[name]}, true))


def test_an_offset_costs_nothing_and_a_constant_has_no_correlation():
    _, true = utterances()
    found = score({name: values + 5 for name, values in true.items()}, true)
    assert found["rmse_appearance"] == pytest.approx(0, abs=1e-12) and found["corr"] == pytest.approx(1)
    still = score({name: np.zeros(values.shape) for name, values in true.items()}, true)
    assert still["corr"] == 0 and still["gv_ratio"] == 0


@pytest.mark.parametrize(
    ("predicted", "true", "said"),
    [
        ({}, {}, "no prediction to score"),
        ({"a": np.zeros((3, 2))}, {}, "no truth of the utterance a"),
        ({"a": np.zeros((3, 2))}, {"a": np.zeros((4, 2))}, r"a: predicted appearance \(3, 2\), but true"),
        (np.zeros(3), np.zeros(3), r"numbers of shape \(T, N\), not float64 \(3,\)"),
        (np.zeros((0, 2)), np.zeros((0, 2)), "has 0 frames"),
        (np.full((3, 2), np.nan), np.zeros((3, 2)), "frame 0 is not a finite number"),
        (np.array([["a"]]), np.zeros((1, 1)), "numbers of shape"),
    ],
)
def test_mistakes_are_reported(predicted, true, said):
    with pytest.raises(DataError, match=said):
        score(predicted, true)
