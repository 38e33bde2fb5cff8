from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from tests.unit.models.hmm.speech import PHONES, TEST, TRAINING, error, likelihoods, utterances
from visualspeech.errors import DataError, SettingError
from visualspeech.features.resampling import resample
from visualspeech.models.hmm.chains import even_states
from visualspeech.models.hmm.mge import refine
from visualspeech.models.hmm.model import Hmm, HmmSettings
from visualspeech.models.hmm.segments import ContextLayout, PhoneTrack
from visualspeech.models.hmm.statistics import Gaussians, accumulate, prepare
from visualspeech.models.hmm.training import fit_monophones, fit_tied
from visualspeech.models.hmm.tying import monophones
from visualspeech.speech.phones import PHONES as PHONE_SET
from visualspeech.storage.models import read_model, write_model

SMALL = HmmSettings(states=3, rate=50.0, min_frames=4, mdl_factor=0.5)


@pytest.fixture(scope="module")
def monophone():
    return fit_monophones(TRAINING, PHONES, SMALL)


@pytest.fixture(scope="module")
def tied(monophone):
    return fit_tied(monophone, TRAINING)


@pytest.mark.parametrize("stage", ["monophone", "tied"])
def test_baum_welch_never_lowers_the_likelihood(monophone, stage):
    more = replace(SMALL, monophone_iterations=8, tied_iterations=8)
    if stage == "monophone":
        hmm = fit_monophones(TRAINING, PHONES, more)
    else:
        hmm = fit_tied(replace(monophone, settings=more), TRAINING)
    found = likelihoods(hmm, stage)
    assert len(found) == 8 and np.all(np.diff(found) > -1e-6 * np.abs(found[1:]))
    assert found[-1] - found[0] > 0.02


def test_the_likelihood_of_an_iteration_is_that_of_every_path():
    """The last iteration reports what the Gaussians of the one before give, summed over all paths of each phone."""
    before = fit_monophones(TRAINING[:4], PHONES, replace(SMALL, monophone_iterations=1))
    total, frames = 0.0, 0
    for example in TRAINING[:4]:
        one = prepare(example, SMALL.rate, SMALL.step)
        chosen = np.repeat(before.tying.find(one.contexts), one.lengths, axis=0)
        density = before.gaussians.log_density(one.observed, chosen)
        for start, length, unit in zip(np.cumsum(one.lengths) - one.lengths, one.lengths, one.units, strict=True):
            own = density[start : start + length]
            if length < SMALL.states:
                total += own[np.arange(length), even_states(np.array([length]), SMALL.states)].sum()
                continue
            stay, every = before.self_transition[unit], -np.inf
            for cuts in combinations(range(1, length), SMALL.states - 1):
                path = np.searchsorted(cuts, np.arange(length), side="right")
                spent = np.bincount(path, minlength=SMALL.states)
                chance = ((spent - 1) * np.log(stay) + np.log1p(-stay)).sum()
                every = np.logaddexp(every, chance + own[np.arange(length), path].sum())
            total += every
        frames += len(one.observed)
    again = fit_monophones(TRAINING[:4], PHONES, replace(SMALL, monophone_iterations=2))
    assert np.isclose(likelihoods(again, "monophone")[1], total / frames, rtol=1e-9)


def test_even_start_against_means_frame_by_frame():
    tying = monophones(len(PHONES), 3)
    self_transition = np.full((len(PHONES), 3), 0.5)
    sums = accumulate(TRAINING, tying.find, tying.gaussians, None, self_transition, 50.0, 2)
    groups = {}
    for example in TRAINING:
        one = prepare(example, 50.0, 2)
        phones = np.repeat(one.units, one.lengths)
        for phone, state, seen in zip(phones, even_states(one.lengths, 3), one.observed, strict=True):
            groups.setdefault(3 * phone + state, []).append(seen)
    prior = Gaussians(np.zeros((18, 6)), np.ones((18, 6)), np.ones(18), np.ones(18))
    found = sums.gaussians(np.zeros(6), prior, weight=0)
    for number, rows in groups.items():
        assert np.allclose(found.mean[number], np.mean(rows, axis=0))
        assert np.allclose(found.variance[number], np.var(rows, axis=0), rtol=1e-6)
        assert sums.occupancy[number] == len(rows)


def test_densities_against_scipy():
    from scipy.stats import norm

    generator = np.random.default_rng(0)
    gaussians = Gaussians(generator.normal(size=(7, 4)), generator.uniform(0.5, 2, size=(7, 4)), *np.ones((2, 7)))
    seen, chosen = generator.normal(size=(5, 4)), generator.integers(0, 7, size=(5, 3))
    expected = norm.logpdf(seen[:, None], gaussians.mean[chosen], np.sqrt(gaussians.variance[chosen])).sum(axis=-1)
    assert np.allclose(gaussians.log_density(seen, chosen), expected)


def test_tied_triphones_beat_monophones_and_those_the_mean(monophone, tied):
    values = np.concatenate([seen for _, seen, _ in TRAINING])
    mean = np.mean([np.mean((seen - values.mean(axis=0)) ** 2) for _, seen, _ in TEST])
    assert error(tied) < 0.9 * error(monophone) < 0.9 * 0.7 * mean
    assert monophone.tying.gaussians == len(PHONES) * 3
    assert tied.tying.gaussians < 3 * tied.about["contexts"]


def kept(hmm, path):
    """The HMMs through a file."""
    arrays, plain = hmm.state()
    write_model(path, arrays, plain)
    return Hmm.restore(*read_model(path))


def test_same_input_same_bytes(tied, tmp_path):
    kept(tied, tmp_path / "one")
    kept(fit_tied(fit_monophones(TRAINING, PHONES, SMALL), TRAINING), tmp_path / "two")
    assert (tmp_path / "one").read_bytes() == (tmp_path / "two").read_bytes()


def test_state_and_restore(tied, tmp_path):
    loaded = kept(tied, tmp_path / "hmm.safetensors")
    track, seen, rate = TEST[0]
    assert np.array_equal(loaded.predict(track, len(seen), rate), tied.predict(track, len(seen), rate))
    assert (loaded.settings, loaded.phones) == (SMALL, PHONES)
    assert len(loaded.history_table()) == SMALL.monophone_iterations + SMALL.tied_iterations


def test_prediction_at_any_rate_and_length(tied):
    track, seen, rate = TEST[0]
    whole = tied.predict(track, len(seen), rate)
    assert whole.dtype == np.float32 and whole.shape == seen.shape
    double = tied.predict(track, 2 * len(seen), 2 * rate)
    assert np.abs((double[::2] + double[1::2]) / 2 - whole).max() < 0.2 * seen.std()
    assert tied.predict(track, 1, rate).shape == (1, 2)


@pytest.mark.parametrize(("rate", "loss"), [(50.0, 0.25), (75.0, 0.0), (100.0, 0.125), (125.0, 0.0), (25.0, 0.0)])
def test_reading_keeps_what_the_frames_hold(tied, rate, loss):
    """From 25 Hz to the rate of the HMMs and back: each frame lends a share ``loss`` to its neighbours."""
    hmm = replace(tied, settings=replace(SMALL, rate=rate, reading="centre"))
    values = np.random.default_rng(3).normal(size=(40, 2))
    read = hmm.read(resample(values, 25.0, rate), 40, 25.0)
    padded = np.pad(values, ((1, 1), (0, 0)), mode="edge")
    assert np.allclose(read, (1 - loss) * values + loss / 2 * (padded[:-2] + padded[2:]))


@pytest.mark.parametrize("reading", ["mean", "centre"])
def test_predictions_are_the_frames_of_the_trajectory(tied, reading):
    hmm, (track, seen, rate) = replace(tied, settings=replace(SMALL, reading=reading)), TEST[0]
    values = hmm.trajectory(hmm.states_of(*track.runs(2 * len(seen), 2 * rate))).values
    fine = (np.arange(len(seen) * 1000) + 0.5) / (1000 * rate)
    line = np.stack([np.interp(fine, (np.arange(len(values)) + 0.5) / (2 * rate), one) for one in values.T], axis=1)
    # Two frames at 50 Hz lie evenly about the centre of one at 25 Hz.
    expected = {"mean": line.reshape(-1, 1000, 2).mean(axis=1), "centre": (values[::2] + values[1::2]) / 2}[reading]
    assert np.allclose(hmm.predict(track, len(seen), rate), expected, rtol=1e-4, atol=1e-4)


def test_a_stream_at_the_rate_of_the_hmms():
    slow = replace(SMALL, rate=25.0)
    hmm = fit_tied(fit_monophones(TRAINING, PHONES, slow), TRAINING)
    seen = np.concatenate([values for _, values, _ in TEST])
    assert error(hmm) < 0.5 * np.var(seen, axis=0).mean()
    track, values, rate = TEST[0]
    states = hmm.states_of(*track.runs(len(values), rate))
    assert np.allclose(hmm.predict(track, len(values), rate), hmm.trajectory(states).values, rtol=1e-6)


def test_data_that_does_not_fit(tied):
    with pytest.raises(DataError, match="no training utterance"):
        fit_monophones([], PHONES, SMALL)
    track, seen, rate = TRAINING[0]
    with pytest.raises(DataError, match="not finite"):
        fit_monophones([(track, seen * np.nan, rate)], PHONES, SMALL)
    with pytest.raises(DataError, match="not among the 2 phones"):
        replace(tied, phones=PHONES[:2]).predict(track, 5, rate)
    with pytest.raises(DataError, match="no frame"):
        tied.predict(track, 0, rate)
    wide = utterances(2, neighbours=2)
    with pytest.raises(DataError, match="5 columns, the phone in column 2; those of the HMMs have 3"):
        tied.predict(wide[0][0], 5, rate)
    with pytest.raises(DataError, match="differ in the layout"):
        fit_monophones([*TRAINING[:2], *wide], PHONES, SMALL)
    with pytest.raises(DataError, match="contexts of 3 columns, .* utterances have 5"):
        fit_tied(fit_monophones(TRAINING[:2], PHONES, SMALL), wide)


@pytest.mark.parametrize("change", [{"states": 0}, {"rate": 0}, {"mdl_factor": -1}, {"mge_epochs": 0}])
def test_settings_out_of_range_are_named(change):
    with pytest.raises(SettingError, match=f"models.{next(iter(change))}"):
        HmmSettings(**change)


def widened(examples, left, right):
    """The same utterances with one more column on either side, which holds one phone throughout."""
    for track, values, rate in examples:
        count = len(track.contexts)
        contexts = np.column_stack([np.full(count, left), track.contexts, np.full(count, right)])
        yield PhoneTrack(contexts, track.starts, track.centre + 1), values, rate


def test_outer_columns_of_one_phone_change_nothing(tied):
    found = fit_tied(fit_monophones(list(widened(TRAINING, 2, 4)), PHONES, SMALL), list(widened(TRAINING, 2, 4)))
    assert np.array_equal(found.tying.positions, tied.tying.positions + 1)
    for name in ("roots", "members", "branches"):
        assert np.array_equal(getattr(found.tying, name), getattr(tied.tying, name))
    assert np.array_equal(found.gaussians.mean, tied.gaussians.mean)
    for (track, values, rate), (wide, *_) in zip(TEST, widened(TEST, 2, 4), strict=True):
        assert np.array_equal(found.predict(wide, len(values), rate), tied.predict(track, len(values), rate))


def test_quinphones_train_tie_and_predict(tmp_path):
    given = {"far": 0.6, "noise": 0.1}
    narrow, wide, test = utterances(60, **given), utterances(60, neighbours=2, **given), utterances(10, 7, **given)
    hmm = fit_tied(fit_monophones(wide, PHONES, SMALL), wide)
    assert hmm.tying.layout == ContextLayout(5, 2) and 4 in hmm.tying.positions
    beyond = utterances(10, 7, neighbours=2, **given)
    triphone = fit_tied(fit_monophones(narrow, PHONES, SMALL), narrow)
    assert error(hmm, beyond) < 0.9 * error(triphone, test)
    track, values, rate = beyond[0]
    again = kept(hmm, tmp_path / "hmm.safetensors")
    assert np.array_equal(again.predict(track, len(values), rate), hmm.predict(track, len(values), rate))
    refined = refine(replace(hmm, settings=replace(SMALL, mge_epochs=1)), wide[:8], beyond)
    assert refined.tying.layout == ContextLayout(5, 2) and error(refined, beyond) <= error(hmm, beyond)


def test_contexts_too_wide_to_number_as_digits():
    """40 phones in 13 columns are more than 64 bits hold."""
    generator = np.random.default_rng(0)
    examples = [
        (PhoneTrack(generator.integers(0, 40, (6, 13)).astype(np.int16), np.arange(6) * 0.2, 6), values, 25.0)
        for values in generator.normal(size=(12, 30, 2))
    ]
    hmm = fit_tied(fit_monophones(examples, tuple(PHONE_SET), replace(SMALL, mdl_factor=0.0, min_frames=1)), examples)
    assert hmm.about["contexts"] == len({tuple(row) for track, *_ in examples for row in track.contexts.tolist()})
    # Noise: what is learned is by heart, each context for itself.
    assert error(hmm, examples) < 0.7 * np.var(np.concatenate([values for _, values, _ in examples]), axis=0).mean()


def divided(examples, seed=1, bend=0.0):
    """The same utterances in rows of three divisions a phone, at random times; ``bend`` moves the second division."""
    generator = np.random.default_rng(seed)
    for track, values, rate in examples:
        lasting = np.diff(np.r_[track.starts, track.starts[-1] + 0.15])
        cuts = np.sort(generator.uniform(0.1, 0.9, (len(lasting), 2)), axis=1)
        starts = (track.starts[:, None] + lasting[:, None] * np.column_stack([np.zeros(len(lasting)), cuts])).ravel()
        numbers = np.tile(np.arange(3), len(lasting))
        contexts = np.column_stack([np.repeat(track.contexts, 3, axis=0), numbers])
        time = (np.arange(len(values)) + 0.5) / rate
        moved = values + bend * (numbers[np.searchsorted(starts, time, side="right") - 1] == 1)[:, None]
        yield PhoneTrack(contexts, starts, track.centre, 3), moved.astype(np.float32), rate


@pytest.mark.parametrize("states", [3, 6])
def test_divided_monophones_are_monophones_of_more_phones(states):
    """A phone in three divisions, against three phones in a row of an inventory of 3 K."""
    examples = list(divided(TRAINING[:10]))
    apart = []
    for track, values, rate in examples:
        units = 3 * track.contexts[:, 1] + track.contexts[:, 3]
        none = np.zeros_like(units)
        apart.append((PhoneTrack(np.column_stack([none, units, none]), track.starts, 1), values, rate))
    found = fit_monophones(examples, PHONES, replace(SMALL, states=states))
    names = tuple(f"{phone}{number}" for phone in PHONES for number in range(3))
    expected = fit_monophones(apart, names, replace(SMALL, states=states // 3))
    assert np.array_equal(found.gaussians.mean, expected.gaussians.mean)
    assert np.array_equal(found.self_transition.ravel(), expected.self_transition.ravel())
    for (track, seen, rate), (other, *_) in zip(examples, apart, strict=True):
        assert np.array_equal(found.predict(track, len(seen), rate), expected.predict(other, len(seen), rate))


def of_phones(examples):
    """Divided utterances without the times of the divisions."""
    return [(PhoneTrack(track.contexts[::3, :3], track.starts[::3], 1), seen, rate) for track, seen, rate in examples]


def test_known_times_within_phones_are_worth_what_they_tell(tmp_path):
    training, test = list(divided(TRAINING, bend=20.0)), list(divided(TEST, 2, bend=20.0))
    alone, test_alone = of_phones(training), of_phones(test)
    blind = fit_tied(fit_monophones(alone, PHONES, SMALL), alone)
    hmm = fit_tied(fit_monophones(training, PHONES, SMALL), training)
    assert error(hmm, test) < 0.8 * error(blind, test_alone)
    track, values, rate = test[0]
    again = kept(hmm, tmp_path / "hmm.safetensors")
    assert np.array_equal(again.predict(track, len(values), rate), hmm.predict(track, len(values), rate))
    refined = refine(replace(hmm, settings=replace(SMALL, mge_epochs=2)), training, test)
    assert error(refined, test) < error(hmm, test)


def test_divisions_that_do_not_fit(tied):
    track, values, rate = next(divided(TRAINING[:1]))
    with pytest.raises(DataError, match="phones divided in 3; those of the HMMs have 3 columns"):
        tied.predict(track, len(values), rate)
    with pytest.raises(DataError, match="`states: 5` of the HMMs must be a multiple of 3"):
        fit_monophones([(track, values, rate)], PHONES, replace(SMALL, states=5))
