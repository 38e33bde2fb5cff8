"""Objectives by the definition: gradients by finite differences, values over a corpus against plain numpy."""

import numpy as np
import pytest
import torch

from visualspeech.models.objectives import objective_of
from visualspeech.models.training_settings import OBJECTIVES as NAMES
from visualspeech.models.training_settings import training_settings

LENGTHS = (9, 7, 4)
WEIGHT = 0.3  # of the offset
OBJECTIVES = {name: objective_of(training_settings(objective=name, offset_weight=WEIGHT)) for name in NAMES}


def made(seed=0, lengths=LENGTHS, width=3, fill=0.0):
    """Predicted and true values (B, T, N) in double precision; ``fill`` stands in the padding of the prediction."""
    generator = np.random.default_rng(seed)
    parts = []
    for padding in (fill, 0.0):
        values = np.full((len(lengths), max(lengths), width), padding)
        for row, length in enumerate(lengths):
            values[row, :length] = generator.normal(size=(length, width)) * [1, 2, 0.5] + generator.normal(size=width)
        parts.append(torch.tensor(values))
    # What is predicted follows what is true.
    predicted, true = parts
    inside = (torch.arange(max(lengths)) < torch.tensor(lengths)[:, None])[..., None]
    return predicted + 0.8 * true * inside, true, torch.tensor(lengths)


def frames_of(batch):
    """All real frames of a batch: (frames, N) of both."""
    predicted, true, lengths = batch
    rows = [(predicted[row, :length], true[row, :length]) for row, length in enumerate(lengths.tolist())]
    return (torch.cat(side).numpy() for side in zip(*rows, strict=True))


def concordance(x, y):
    """Lin (1989), written out for one dimension."""
    mean_x, mean_y = sum(x) / len(x), sum(y) / len(y)
    var_x = sum((value - mean_x) ** 2 for value in x) / len(x)
    var_y = sum((value - mean_y) ** 2 for value in y) / len(y)
    covariance = sum((a - mean_x) * (b - mean_y) for a, b in zip(x, y, strict=True)) / len(x)
    return 2 * covariance / (var_x + var_y + (mean_x - mean_y) ** 2)


def slow(name, predicted, true, lengths=()):
    """The value over frames (T, N) of utterances of ``lengths`` frames by definition."""
    if name == "sse_centred":
        total, errors = 0.0, np.split(predicted - true, np.cumsum(lengths)[:-1])
        for error in errors:
            mean = sum(error) / len(error)
            total += sum(float(np.sum((frame - mean) ** 2)) for frame in error) + WEIGHT * len(error) * mean @ mean
        return total / 2 / len(true)
    if name == "sse":
        return 0.5 * sum(float(value) ** 2 for value in (predicted - true).ravel()) / len(true)
    if name == "mse":
        return float(np.mean((predicted - true) ** 2))
    return 1 - np.mean([concordance(x, y) for x, y in zip(predicted.T, true.T, strict=True)])


def value(name, corpus):
    """The value over a corpus, from the statistics of its batches."""
    objective = OBJECTIVES[name]
    sums = sum(objective.statistics(objective.loss(*batch), *batch) for batch in corpus)
    return objective.value(sums, sum(int(batch[2].sum()) for batch in corpus))


def test_an_offset_of_an_utterance_counts_by_its_weight_alone():
    predicted, true, lengths = made()
    inside = (torch.arange(max(LENGTHS)) < lengths[:, None])[..., None]
    moved = predicted + inside * torch.tensor([[[3.0]], [[-2.0]], [[0.5]]])
    for weight, same in ((0.0, True), (WEIGHT, False)):
        objective = objective_of(training_settings(objective="sse_centred", offset_weight=weight))
        losses = [objective.loss(one, true, lengths).item() for one in (predicted, moved)]
        assert (losses[0] == pytest.approx(losses[1], rel=1e-12)) == same
    plain, whole = (training_settings(objective=name, offset_weight=1.0) for name in ("sse", "sse_centred"))
    losses = [objective_of(one).loss(predicted, true, lengths).item() for one in (plain, whole)]
    assert losses[0] == pytest.approx(losses[1], rel=1e-12)


def test_error_is_half_the_sum_of_squares():
    # Two frames of two dimensions: (1 + 4 + 0 + 9) / 2.
    predicted, true = torch.tensor([[[1.0, 2], [3, 4]]]), torch.tensor([[[0.0, 0], [3, 1]]])
    assert OBJECTIVES["sse"].loss(predicted, true, torch.tensor([2])).item() == 7.0
    assert OBJECTIVES["mse"].loss(predicted, true, torch.tensor([2])).item() == 3.5


@pytest.mark.parametrize("name", sorted(OBJECTIVES))
def test_gradient_by_finite_difference(name):
    predicted, true, lengths = made()
    predicted.requires_grad_()
    OBJECTIVES[name].loss(predicted, true, lengths).backward()
    for place in [(0, 0, 0), (1, 6, 2), (2, 3, 1), (0, 8, 1)]:
        step = torch.zeros_like(predicted)
        step[place] = 1e-6
        with torch.no_grad():
            above, below = (OBJECTIVES[name].loss(predicted + sign * step, true, lengths).item() for sign in (1, -1))
        assert predicted.grad[place].item() == pytest.approx((above - below) / 2e-6, rel=1e-5, abs=1e-9)


@pytest.mark.parametrize("name", sorted(OBJECTIVES))
def test_the_loss_of_a_batch_is_its_value(name):
    batch = made()
    loss = OBJECTIVES[name].loss(*batch).item()
    per_frame = sum(LENGTHS) if OBJECTIVES[name].additive else 1
    assert loss / per_frame == pytest.approx(slow(name, *frames_of(batch), LENGTHS), rel=1e-9)


@pytest.mark.parametrize("name", sorted(OBJECTIVES))
def test_the_value_over_a_corpus_is_that_of_all_its_frames(name):
    corpus = [made(1), made(2, (5, 2)), made(3, (12,))]
    x, y = (np.concatenate(side) for side in zip(*(frames_of(batch) for batch in corpus), strict=True))
    assert value(name, corpus) == pytest.approx(slow(name, x, y, (*LENGTHS, 5, 2, 12)), rel=1e-9)


def test_concordance_over_a_corpus_is_no_mean_over_batches():
    corpus = [made(1), made(2, (5, 2)), made(3, (12,))]
    of_batches = [slow("ccc", *frames_of(batch)) for batch in corpus]
    weights = [int(batch[2].sum()) for batch in corpus]
    for mean in (np.mean(of_batches), np.average(of_batches, weights=weights)):
        assert abs(value("ccc", corpus) - mean) > 0.02


def test_a_perfect_prediction_agrees_and_a_constant_does_not():
    _, true, lengths = made()
    assert OBJECTIVES["ccc"].loss(true, true, lengths).item() == pytest.approx(0, abs=1e-9)
    assert OBJECTIVES["ccc"].loss(torch.zeros_like(true), torch.zeros_like(true), lengths).item() == 1
    constant = torch.ones_like(true).requires_grad_()
    loss = OBJECTIVES["ccc"].loss(constant, true, lengths)
    loss.backward()
    assert loss.item() == pytest.approx(1) and torch.isfinite(constant.grad).all()


def test_frames_beyond_the_end_do_not_count_for_the_concordance():
    clean, filled = made(), made(fill=5.0)
    assert OBJECTIVES["ccc"].loss(*filled).item() == OBJECTIVES["ccc"].loss(*clean).item()
    assert value("ccc", [filled]) == value("ccc", [clean])


@pytest.mark.parametrize("name", sorted(OBJECTIVES))
def test_longer_padding_changes_nothing(name):
    predicted, true, lengths = made()
    wider = [torch.nn.functional.pad(part, (0, 0, 0, 6)) for part in (predicted, true)]
    assert value(name, [(*wider, lengths)]) == pytest.approx(value(name, [(predicted, true, lengths)]), rel=1e-12)


def test_concordance_of_values_far_from_zero_in_single_precision():
    """Statistics are taken in double precision, so that a large offset does not drown what varies."""
    predicted, true, lengths = made(4, (400, 300))
    inside = (torch.arange(400) < lengths[:, None])[..., None]
    shifted = [((part + 1000) * inside).float() for part in (predicted, true)]
    x, y = (side.astype(np.float64) for side in frames_of((*shifted, lengths)))
    objective = OBJECTIVES["ccc"]
    sums = objective.statistics(torch.tensor(0.0), *shifted, lengths)
    assert objective.value(sums, 700) == pytest.approx(slow("ccc", x, y), rel=1e-4)
