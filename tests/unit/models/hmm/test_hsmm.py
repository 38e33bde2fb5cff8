"""Hidden semi-Markov models: training with explicit durations, contexts with numbers, generation, files."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from scipy.stats import norm

from tests.unit.models.examples import task
from tests.unit.models.hmm.speech import PHONES, TEST, TRAINING, error, likelihoods, utterances
from tests.unit.speech.test_structure import utterance
from visualspeech.errors import DataError, StorageError
from visualspeech.features.blocks.base import Source
from visualspeech.features.blocks.full_context import FACTORS, FullContext, FullContextSettings
from visualspeech.features.contexts import phone_inventory
from visualspeech.features.examples import Example
from visualspeech.models.hmm import family
from visualspeech.models.hmm.chains import even_states
from visualspeech.models.hmm.mge import generation_error, refine
from visualspeech.models.hmm.model import Hmm, HmmSettings
from visualspeech.models.hmm.segments import Factor, PhoneTrack, layout_text
from visualspeech.models.hmm.statistics import accumulate, prepare
from visualspeech.models.hmm.training import fit_monophones, fit_tied
from visualspeech.models.registry import load_model
from visualspeech.models.trajectory.windows import observations
from visualspeech.storage.models import read_model, write_model

SMALL = HmmSettings(durations="gaussian", states=3, rate=50.0, min_frames=4, mdl_factor=0.5)


@pytest.fixture(scope="module")
def monophone():
    return fit_monophones(TRAINING, PHONES, SMALL)


@pytest.fixture(scope="module")
def tied(monophone):
    return fit_tied(monophone, TRAINING)


@pytest.mark.parametrize("stage", ["monophone", "tied"])
def test_training_never_lowers_the_likelihood(monophone, stage):
    more = replace(SMALL, monophone_iterations=8, tied_iterations=8)
    if stage == "monophone":
        hmm = fit_monophones(TRAINING, PHONES, more)
    else:
        hmm = fit_tied(replace(monophone, settings=more), TRAINING)
    found = likelihoods(hmm, stage)
    assert len(found) == 8 and np.all(np.diff(found) > -1e-6 * np.abs(found[1:]))
    assert found[-1] - found[0] > 0.02


def test_the_likelihood_of_an_iteration_is_that_of_every_path():
    before = fit_monophones(TRAINING[:3], PHONES, replace(SMALL, monophone_iterations=1))
    total, frames = 0.0, 0
    for example in TRAINING[:3]:
        one = prepare(example, SMALL.rate, SMALL.step)
        rows = before.tying.find(one.contexts)
        for end, length, chosen in zip(np.cumsum(one.lengths), one.lengths, rows, strict=True):
            here = before.gaussians.at(chosen)
            own = before.gaussians.log_density(one.observed[end - length : end], np.tile(chosen, (length, 1)))
            cuts = combinations(range(1, length), SMALL.states - 1)
            paths = [np.searchsorted(cut, np.arange(length), side="right") for cut in cuts]
            if length < SMALL.states:
                paths = [even_states(np.array([length]), SMALL.states)]
            every = [
                own[np.arange(length), path].sum()
                + norm.logpdf(np.bincount(path, minlength=3), here.duration_mean, here.duration_variance**0.5).sum()
                for path in paths
            ]
            total += np.logaddexp.reduce(every)
        frames += len(one.observed)
    again = fit_monophones(TRAINING[:3], PHONES, replace(SMALL, monophone_iterations=2))
    assert np.isclose(likelihoods(again, "monophone")[1], total / frames, rtol=1e-9)


def test_estimated_durations_are_the_most_likely_ones(monophone):
    tying = monophone.tying
    self_transition = monophone.self_transition
    sums = accumulate(
        TRAINING, tying.find, tying.gaussians, monophone.gaussians, self_transition, 50.0, SMALL.step, "gaussian"
    )
    found = sums.gaussians(np.zeros(6), monophone.gaussians, weight=0)

    def value(mean, variance):
        """Expected log-density of all durations of each Gaussian."""
        squares = sums.squared_durations - 2 * mean * sums.durations + sums.visits * mean**2
        return -0.5 * (sums.visits * np.log(2 * np.pi * variance) + squares / variance)

    spread = sums.squared_durations / sums.visits - (sums.durations / sums.visits) ** 2
    free = spread > 0.01 * (found.duration_mean**2 + 1)
    assert free.sum() > len(free) / 2
    best = value(found.duration_mean, found.duration_variance)[free]
    for factor in (0.97, 1.03):
        assert (value(factor * found.duration_mean, found.duration_variance)[free] < best).all()
        assert (value(found.duration_mean, factor * found.duration_variance)[free] < best).all()


def test_generation_against_a_slow_one(tied):
    track, seen, rate = TEST[0]
    contexts, lengths = track.runs(round(len(seen) * 50 / rate), 50.0)
    states = []
    for context, length in zip(contexts, lengths, strict=True):
        here = tied.gaussians.at(tied.tying.find(context[None])[0])
        rho = (length - here.duration_mean.sum()) / here.duration_variance.sum()
        spent = np.maximum(here.duration_mean + rho * here.duration_variance, 0.1 * here.duration_mean)
        ends = np.cumsum(spent) * length / spent.sum()
        for frame in range(length):
            state = next(number for number in range(3) if frame + 0.5 < ends[number] or number == 2)
            states.append(tied.tying.find(context[None])[0, state])
    frames = len(states)
    window = observations(np.eye(frames), SMALL.step).reshape(frames, 3, frames).transpose(1, 0, 2).reshape(-1, frames)
    expected = np.zeros((frames, 2))
    for column in range(2):
        mean = tied.gaussians.mean[states][:, column::2].T.ravel()
        precision = 1 / tied.gaussians.variance[states][:, column::2].T.ravel()
        weighted = window.T * precision
        expected[:, column] = np.linalg.solve(weighted @ window, weighted @ mean)
    assert np.allclose(tied.trajectory(np.array(states)).values, expected, rtol=1e-6, atol=1e-8)
    assert tied.states_at(track, len(seen), rate).tolist() == states
    assert np.allclose(tied.predict(track, frames, 50.0), expected, rtol=1e-5, atol=1e-5)


def test_hsmms_are_as_good_as_hmms(monophone, tied):
    plain = replace(SMALL, durations="geometric")
    before = fit_monophones(TRAINING, PHONES, plain)
    assert error(monophone) < 1.03 * error(before) and error(tied) < 1.03 * error(fit_tied(before, TRAINING))
    assert likelihoods(monophone, "monophone") != likelihoods(before, "monophone")


WORDS = (Factor("word in phrase", 9), Factor("words in phrase", 9))


def numbered(examples, shift=6.0):
    """The same utterances with two numbers for each phone, of which the first one moves the pose from 5 on."""
    generator = np.random.default_rng(3)
    for track, values, rate in examples:
        numbers = generator.integers(0, 9, (len(track.starts), 2))
        time = (np.arange(len(values)) + 0.5) / rate
        high = numbers[np.searchsorted(track.starts, time, side="right") - 1, 0] >= 5
        contexts = np.concatenate([track.contexts, numbers], axis=1)
        moved = (values + shift * high[:, None]).astype(np.float32)
        yield PhoneTrack(contexts, track.starts, track.centre, factors=WORDS), moved, rate


@pytest.fixture(scope="module")
def placed():
    training, test = list(numbered(utterances(60, neighbours=2))), list(numbered(utterances(10, 7, neighbours=2)))
    return fit_tied(fit_monophones(training, PHONES, SMALL), training), training, test


def test_trees_ask_about_numbers(placed, tmp_path):
    hmm, training, test = placed
    assert hmm.tying.layout[:3] == (5, 2, 1) and hmm.tying.factors == WORDS
    assert (hmm.tying.positions == 5).any() and (hmm.tying.positions == 6).sum() <= 3
    blind = [(PhoneTrack(track.contexts[:, :5], track.starts, 2), values, rate) for track, values, rate in training]
    without = fit_tied(fit_monophones(blind, PHONES, SMALL), blind)
    blind = [(PhoneTrack(track.contexts[:, :5], track.starts, 2), values, rate) for track, values, rate in test]
    assert error(hmm, test) < 0.8 * error(without, blind)
    arrays, plain = hmm.state()
    write_model(tmp_path / "hsmm.safetensors", arrays, plain)
    again = Hmm.restore(*read_model(tmp_path / "hsmm.safetensors"))
    track, values, rate = test[0]
    assert again.tying.layout == hmm.tying.layout and again.settings == SMALL
    assert np.array_equal(again.predict(track, len(values), rate), hmm.predict(track, len(values), rate))


def test_mge_training_of_hsmms(placed):
    hmm, training, test = placed
    refined = refine(replace(hmm, settings=replace(SMALL, mge_epochs=2)), training, test)
    assert generation_error(refined, test) < generation_error(hmm, test)
    assert refined.tying.layout == hmm.tying.layout


def test_contexts_that_do_not_fit(placed):
    hmm, _, test = placed
    track, values, rate = test[0]
    assert layout_text(track.layout) == "5 columns, the phone in column 2, 2 factors beside the phones"
    with pytest.raises(DataError, match="have 5 columns, the phone in column 2; those of the HMMs have .* 2 factors"):
        hmm.predict(PhoneTrack(track.contexts[:, :5], track.starts, 2), len(values), rate)
    for column, number, said in ((5, 9, "numbers of units that are larger"), (2, 6, "phones that are not among the 6")):
        contexts = track.contexts.copy()
        contexts[1, column] = number
        with pytest.raises(DataError, match=said):
            hmm.predict(replace(track, contexts=contexts), len(values), rate)
    with pytest.raises(DataError, match="do not fit"):
        PhoneTrack(track.contexts[:, :2], track.starts, 0, factors=WORDS)


SPOKEN = utterance()
INVENTORY = tuple(phone_inventory([SPOKEN]))
BLOCKS = {"context": FullContext(INVENTORY)}
PLAIN = {"durations": "gaussian", "states": 3, "rate": 50.0, "min_frames": 4.0, "mdl_factor": 0.1, "mge_epochs": 1}


def spoken(number):
    """The utterance in the pace of its number, with a trajectory that follows its phones and its words."""
    pace = 1 + 0.1 * number
    slower = tuple(replace(one, start=pace * one.start, end=pace * one.end) for one in SPOKEN.phones)
    alignment = replace(SPOKEN, phones=slower)
    frames = int(slower[-1].end * 25)
    (stream,) = BLOCKS["context"].encode([Source(frames, 25.0, alignment)])
    at = np.searchsorted(stream.starts, (np.arange(frames) + 0.5) / 25, side="right") - 1
    poses = np.random.default_rng(1).normal(size=(len(INVENTORY) + 1, 2))[stream.index[at, 2]]
    words = stream.index[at, 5 + FACTORS.index("word in utterance")]
    noise = np.random.default_rng(number).normal(scale=0.1, size=(frames, 2))
    return Example((stream,), (poses + words[:, None] + noise).astype(np.float32), 25.0)


def test_rows_of_the_family_through_files(tmp_path):
    training, validation = [spoken(number) for number in range(6)], [spoken(7), spoken(8)]
    before = []
    for variant in ("monophone", "tied", "mge"):
        given = task("hmm", {**PLAIN, "variant": variant}, training, validation, BLOCKS, parents=before, coding="abc")
        fitted = family.fit(given)
        before = [tmp_path / f"{variant}.safetensors"]
        fitted.model.save(before[0])
        again = load_model(before[0])
        assert again.blocks == BLOCKS and again.hmm.phones == (*INVENTORY, "sp")
        for one in validation:
            found = again.predict(one.streams, len(one.target), one.rate)
            assert np.array_equal(found, fitted.model.predict(one.streams, len(one.target), one.rate))
            assert variant == "monophone" or np.mean((found - one.target) ** 2) < 0.5 * np.var(one.target)


def test_a_file_whose_block_has_other_columns(tmp_path):
    model = family.fit(task("hmm", {**PLAIN, "variant": "monophone"}, [spoken(0)], [], BLOCKS)).model
    for options in (FullContextSettings(neighbours=1), FullContextSettings(max_number=9)):
        replace(model, blocks={"context": FullContext(INVENTORY, options)}).save(tmp_path / "model.safetensors")
        with pytest.raises(StorageError, match="its phones are not those of its input block"):
            load_model(tmp_path / "model.safetensors")
    arrays, plain = model.hmm.state()
    with pytest.raises(StorageError, match="questions of its trees"):
        Hmm.restore({**arrays, "tying.members": np.zeros((0, 3), bool)}, plain, "model.safetensors")
