"""What training knows of the lips, and the loss on their opening: closed forms, and a training that closes them."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from tests.unit.models.examples import BLOCKS, PHONES, RATE
from tests.unit.speech.alignments import spoken
from visualspeech.errors import DataError
from visualspeech.features.examples import Example
from visualspeech.features.streams import Stream
from visualspeech.models import stack
from visualspeech.models.batches import Scaling
from visualspeech.models.lip_loss import LipLoss
from visualspeech.models.lips import Lips, recorded_lips
from visualspeech.models.rows import ModelRow
from visualspeech.models.task import Task
from visualspeech.models.training_settings import training_settings

WEIGHTS = np.array([1.0, -2.0, 0.5])


ALIGNMENT = spoken(("ah", 0.4), ("b", 0.2), ("aa", 0.4))


def utterance(seed, frames=25):
    parameters = np.random.default_rng(seed).normal(size=(frames, 3)).astype(np.float32)
    return parameters, parameters @ WEIGHTS + 4


def lips_of(*seeds) -> Lips:
    return Lips.of((*utterance(seed), ALIGNMENT, RATE) for seed in seeds)


def test_the_opening_is_a_linear_function_of_the_parameters():
    lips = lips_of(1, 2, 3)
    np.testing.assert_allclose(lips.weights, WEIGHTS, rtol=1e-5)
    assert lips.offset == pytest.approx(4, rel=1e-6)
    every = np.concatenate([utterance(seed)[1] for seed in (1, 2, 3)])
    assert lips.deviation == pytest.approx(every.std(), rel=1e-6)


def test_limits_are_the_recorded_extremes():
    lips = lips_of(1)
    _, opening = utterance(1)
    # "b" from 0.4 to 0.6 s, one frame more on either side: frames 9 to 15; "aa" from 0.6 s on: frames 15 to 24.
    closed, wide = 9 + np.argmin(opening[9:16]), 15 + np.argmax(opening[15:25])
    assert np.flatnonzero(np.isfinite(lips.highest[0])).tolist() == [closed]
    assert np.flatnonzero(np.isfinite(lips.lowest[0])).tolist() == [wide]
    np.testing.assert_allclose([lips.highest[0][closed], lips.lowest[0][wide]], opening[[closed, wide]], rtol=1e-6)


def test_lips_that_never_move_are_refused():
    with pytest.raises(DataError, match="never move"):
        Lips.of([(np.ones((9, 2)), np.full(9, 0.1), ALIGNMENT, RATE)])
    with pytest.raises(DataError, match="no training utterance"):
        Lips.of([])


def slow_loss(lips, scaling, outputs, numbers, closure_weight, open_weight) -> float:
    """Frame by frame, in pixels."""
    total = 0.0
    for values, number in zip(outputs, numbers, strict=True):
        for t in range(len(lips.highest[number])):
            opening = lips.offset + (values[t] * scaling.scale + scaling.mean)[: len(lips.weights)] @ lips.weights
            excess = max(0.0, opening - lips.highest[number][t]) / lips.deviation
            missing = max(0.0, lips.lowest[number][t] - opening) / lips.deviation
            total += closure_weight * excess**2 + open_weight * missing**2
    return 0.5 * len(scaling.mean) * total


@pytest.mark.parametrize("outputs", [3, 9])
def test_the_loss_is_the_squared_error_on_one_side(outputs):
    lips = Lips.of((*utterance(seed, 25 - seed), ALIGNMENT, RATE) for seed in range(4))
    generator = np.random.default_rng(5)
    scaling = Scaling(generator.normal(size=outputs), generator.uniform(1, 2, outputs))
    predicted, numbers = generator.normal(size=(3, 25, outputs)), [2, 0, 3]
    for closure_weight, open_weight in ((0.3, 0.7), (1.0, 0.0), (0.0, 2.0)):
        settings = training_settings(closure_weight=closure_weight, open_weight=open_weight)
        loss = LipLoss.of(lips, scaling, settings)
        found = loss(torch.tensor(predicted, dtype=torch.float32), numbers).item()
        expected = slow_loss(lips, scaling, predicted, numbers, closure_weight, open_weight)
        assert expected > 0 and found == pytest.approx(expected, rel=1e-4)


def test_its_gradient_is_finite_and_zero_where_nothing_is_asked():
    lips, scaling = lips_of(1), Scaling(np.zeros(3), np.ones(3))
    loss = LipLoss.of(lips, scaling, training_settings(closure_weight=1, open_weight=1))
    given = torch.tensor(utterance(1)[0][None] + 0.1, requires_grad=True)
    loss(given, [0]).backward()
    asked = np.isfinite(lips.highest[0]) | np.isfinite(lips.lowest[0])
    moved = given.grad.abs().sum(dim=2)[0].numpy() > 0
    assert np.isfinite(given.grad.numpy()).all() and moved.any() and not moved[~asked].any()
    # The recording itself costs nothing.
    assert loss(torch.tensor(utterance(1)[0][None]), [0]).item() == pytest.approx(0, abs=1e-8)


def test_weights_of_zero_ask_for_nothing():
    assert LipLoss.of(lips_of(1), Scaling(np.zeros(3), np.ones(3)), training_settings()) is None
    assert LipLoss.of(None, Scaling(np.zeros(3), np.ones(3)), training_settings(closure_weight=1)) is None
    assert recorded_lips(ModelRow("a", "a", "stack", {}, training={"closure_weight": 0.0}), ["u"], None, ()) is None


@pytest.mark.parametrize(("objective", "added"), [("sse", True), ("sse_centred", True), ("mse", False), ("ccc", False)])
def test_it_is_added_to_sums_of_squared_errors_only(objective, added):
    settings = training_settings(objective=objective, closure_weight=1)
    assert (LipLoss.of(lips_of(1), Scaling(np.zeros(3), np.ones(3)), settings) is not None) == added


def task(**training) -> Task:
    """Closures that the labels cannot tell: half of the "b" gape in the recording, so their mean does."""
    generator, examples, recorded = np.random.default_rng(0), [], []
    alignment = spoken(("ah", 0.4), ("b", 0.2), ("ah", 0.4))
    index = np.zeros((25, 4), np.int16)
    index[10:15, 1] = PHONES.index("b")
    for number in range(12):
        opening = np.full(25, 6.0)
        opening[10:15] = 1.0 if number % 2 else 5.0
        target = np.column_stack([opening, generator.normal(size=25)]).astype(np.float32)
        examples.append(Example((Stream(index=index),), target, RATE))
        recorded.append((target, opening, alignment, RATE))
    row = ModelRow("F-8", "F-8", "stack", {"letters": "F", "nodes": 8}, ("tri",), training={
        "max_epochs": 60, "patience": 60, "dropout": 0.0, "learning_rate": 0.02, **training})  # fmt: skip
    return Task(row, BLOCKS, examples, examples[:4], lips=Lips.of(recorded))


def test_training_minimises_both_and_its_curve_is_that_of_the_objective():
    plain, weighted = (stack.fit(task(closure_weight=weight)).curve for weight in (0.0, 2.0))
    without = stack.fit(replace(task(closure_weight=2.0), lips=None)).curve
    np.testing.assert_array_equal(plain[["train", "validation"]], without[["train", "validation"]])
    # The mean of both halves has the least error; pulled towards the closed lips, the network has more.
    assert weighted["validation"].iloc[-1] > 1.01 * plain["validation"].iloc[-1]


def test_a_checkpoint_of_other_lips_is_not_used(tmp_path, monkeypatch):
    from visualspeech.models import training

    seen = []
    original = training.write_checkpoint
    monkeypatch.setattr(
        training,
        "write_checkpoint",
        lambda path, identity, state: seen.append(identity) or original(path, identity, state),
    )
    given = replace(task(closure_weight=1.0, max_epochs=1), checkpoint=tmp_path / "checkpoint.safetensors")
    other = replace(given.lips, highest=tuple(values + 1 for values in given.lips.highest))
    for one in (given, given, replace(given, lips=other)):
        stack.fit(one)
    assert seen[0] == seen[1] != seen[2]
