import dataclasses

import numpy as np
import pytest

from visualspeech.models.hmm.questions import questions
from visualspeech.models.hmm.segments import ContextLayout, Factor
from visualspeech.models.hmm.tying import Cases, grow, log_likelihood, monophones

PHONES = ("sil", "aa", "b", "iy", "m")
FLOOR = np.full(2, 1e-3)


def frames_of(triphones, seed=0):
    """Frames of every triphone, which differ by the current phone and by whether a bilabial follows."""
    generator = np.random.default_rng(seed)
    bilabial = np.isin(triphones[:, 2], [2, 4])
    centre = np.stack([3.0 * (triphones[:, 1] == 1), 2.0 * bilabial], axis=1)
    return [generator.normal(mean, 0.5, size=(generator.integers(5, 12), 2)) for mean in centre]


def cases_of(triphones, frames, state=0):
    return Cases(
        triphones,
        np.full(len(triphones), state),
        np.array([float(len(rows)) for rows in frames]),
        np.array([rows.sum(axis=0) for rows in frames]),
        np.array([(rows**2).sum(axis=0) for rows in frames]),
    )


def all_triphones(number=40, seed=1):
    generator = np.random.default_rng(seed)
    return np.unique(generator.integers(0, len(PHONES), size=(number, 3)), axis=0)


def plain_likelihood(rows):
    """Frame by frame, under the Gaussian of these frames."""
    variance = np.maximum(rows.var(axis=0), FLOOR)
    return -0.5 * (np.log(2 * np.pi * variance) + (rows - rows.mean(axis=0)) ** 2 / variance).sum()


def plain_tree(triphones, frames, asked, least, cost):
    """The leaves of the tree, as sets of triphones, by trying every question on the frames themselves."""
    rows = np.concatenate(frames)
    best = (cost, None)
    for question in range(len(asked.names)):
        yes = asked.answers(triphones)[question]
        parts = [[rows for rows, said in zip(frames, yes, strict=True) if said == answer] for answer in (False, True)]
        if min(sum(map(len, part)) for part in parts) < least:
            continue
        gain = sum(plain_likelihood(np.concatenate(part)) for part in parts) - plain_likelihood(rows)
        if gain > best[0] + 1e-9:
            best = (gain, yes)
    if best[1] is None:
        return [sorted(map(tuple, triphones.tolist()))]
    leaves = []
    for answer in (False, True):
        chosen = np.flatnonzero(best[1] == answer)
        leaves += plain_tree(triphones[chosen], [frames[at] for at in chosen], asked, least, cost)
    return leaves


@pytest.mark.parametrize(("mdl", "least"), [(1.0, 5), (0.2, 10), (0.01, 5)])
def test_trees_against_brute_force(mdl, least):
    triphones = all_triphones()
    frames = frames_of(triphones)
    asked = questions(PHONES)
    tying = grow(cases_of(triphones, frames), asked, len(PHONES), 1, 1, FLOOR, least, mdl)
    cost = mdl * 2 * np.log(sum(map(len, frames)))
    expected = plain_tree(triphones, frames, asked, least, cost)
    found = tying.find(triphones)[:, 0]
    leaves = [sorted(map(tuple, triphones[found == leaf].tolist())) for leaf in range(tying.gaussians)]
    assert sorted(leaves) == sorted(expected)
    assert mdl < 1 or tying.gaussians == 4


def test_trees_do_not_depend_on_how_sums_are_rounded():
    """Parts of just as many frames as a Gaussian needs, of counts that are whole but for rounding."""
    triphones = all_triphones()
    cases = cases_of(triphones, [rows[:5] for rows in frames_of(triphones)])
    trees = []
    for seed in range(6):
        noise = 1 + 1e-12 * np.random.default_rng(seed).standard_normal(len(triphones))
        rounded = dataclasses.replace(cases, occupancy=cases.occupancy * noise)
        trees.append(grow(rounded, questions(PHONES), len(PHONES), 1, 1, FLOOR, 15, 0.01))
    plain = grow(cases, questions(PHONES), len(PHONES), 1, 1, FLOOR, 15, 0.01)
    counts = np.bincount(plain.find(triphones)[:, 0], weights=cases.occupancy)
    assert counts.min() == 15
    for tree in trees:
        for name in ("roots", "positions", "members", "branches"):
            assert np.array_equal(getattr(tree, name), getattr(plain, name))


def test_triphones_never_seen_follow_their_answers():
    every = np.stack(np.meshgrid(*[np.arange(len(PHONES))] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    seen = every[np.arange(len(every)) % 7 > 0]
    tying = grow(cases_of(seen, frames_of(seen)), questions(PHONES), len(PHONES), 1, 1, FLOOR, 5, 1.0)
    kind = 2 * (every[:, 1] == 1) + np.isin(every[:, 2], [2, 4])
    leaf = tying.find(every)[:, 0]
    assert len({(a, b) for a, b in zip(kind.tolist(), leaf.tolist(), strict=True)}) == 4


def test_a_tree_for_each_phone_never_mixes_phones():
    triphones = all_triphones(60)
    asked = questions(PHONES)
    tying = grow(cases_of(triphones, frames_of(triphones)), asked, len(PHONES), 1, 1, FLOOR, 5, 1.0, of_each_phone=True)
    leaf = tying.find(triphones)[:, 0]
    for number in range(tying.gaussians):
        assert len(np.unique(triphones[leaf == number, 1])) <= 1


def test_states_have_trees_of_their_own():
    triphones = all_triphones(40)
    both = [cases_of(triphones, frames_of(triphones, seed), seed) for seed in (0, 1)]
    joined = Cases(*(np.concatenate([getattr(part, name) for part in both]) for name in Cases.__dataclass_fields__))
    tying = grow(joined, questions(PHONES), len(PHONES), 2, 1, FLOOR, 5)
    found = tying.find(triphones)
    assert not set(found[:, 0].tolist()) & set(found[:, 1].tolist())
    assert sorted(set(found.ravel().tolist())) == list(range(tying.gaussians))


def test_monophones():
    found = monophones(4, 5).find(np.array([[0, 2, 1], [3, 2, 0], [1, 0, 2]]))
    assert found.tolist() == [[10, 11, 12, 13, 14], [10, 11, 12, 13, 14], [0, 1, 2, 3, 4]]


def test_log_likelihood_against_the_frames():
    rows = np.random.default_rng(0).normal(size=(50, 2)) * [1, 1e-4]
    assert np.isclose(log_likelihood(50.0, rows.sum(axis=0), (rows**2).sum(axis=0), FLOOR), plain_likelihood(rows))


@pytest.mark.parametrize("of_each_phone", [False, True])
def test_columns_that_never_change_leave_the_trees_as_they_are(of_each_phone):
    triphones = all_triphones(60)
    frames = frames_of(triphones)
    wide = np.column_stack([np.full(len(triphones), 3), triphones, np.full(len(triphones), 1)])
    narrow = grow(cases_of(triphones, frames), questions(PHONES), 5, 1, 1, FLOOR, 5, 0.3, of_each_phone)
    found = grow(cases_of(wide, frames), questions(PHONES, 5, 2), 5, 1, 2, FLOOR, 5, 0.3, of_each_phone)
    assert narrow.gaussians > 4 and found.layout == ContextLayout(5, 2)
    assert np.array_equal(found.positions, narrow.positions + 1)
    for name in ("roots", "members", "branches"):
        assert np.array_equal(getattr(found, name), getattr(narrow, name))
    assert np.array_equal(found.find(wide), narrow.find(triphones))


def test_trees_of_quinphones_ask_about_the_outer_phones():
    contexts = np.unique(np.random.default_rng(2).integers(0, len(PHONES), size=(80, 5)), axis=0)
    generator = np.random.default_rng(0)
    frames = [generator.normal(4.0 * (context[0] == 2), 0.5, size=(8, 2)) for context in contexts]
    tying = grow(cases_of(contexts, frames), questions(PHONES, 5, 2), len(PHONES), 1, 2, FLOOR, 5, 1.0)
    assert tying.gaussians == 2 and tying.positions.tolist() == [0]
    leaf = tying.find(contexts)[:, 0]
    assert np.array_equal(leaf == leaf[contexts[:, 0] == 2][0], contexts[:, 0] == 2)


@pytest.mark.parametrize(("states", "divisions"), [(6, 3), (3, 3), (4, 2)])
def test_divisions_of_phones_have_their_share_of_the_states(states, divisions):
    """One tree for each state, found through undivided contexts and through the divisions."""
    triphones = all_triphones()
    rng = np.random.default_rng(3)
    whole = [cases_of(triphones, frames_of(triphones, rng.integers(99)), state) for state in range(states)]
    each = states // divisions
    together = Cases(*(np.concatenate([getattr(one, name) for one in whole]) for name in Cases.__dataclass_fields__))
    numbered = np.column_stack([together.contexts, together.states // each])
    divided = Cases(numbered, together.states, together.occupancy, together.first, together.second)
    expected = grow(together, questions(PHONES), 5, states, 1, FLOOR, 5, 0.3)
    found = grow(divided, questions(PHONES), 5, states, 1, FLOOR, 5, 0.3, divisions=divisions)
    assert found.layout == ContextLayout(3, 1, divisions) and found.unit_states == each and found.gaussians > states
    for division in range(divisions):
        rows = np.column_stack([triphones, np.full(len(triphones), division)])
        own = slice(division * each, (division + 1) * each)
        assert np.array_equal(found.find(rows), expected.find(triphones)[:, own])


@pytest.mark.parametrize(("mdl", "least"), [(1.0, 5), (0.2, 10), (0.01, 5)])
def test_trees_with_factors_against_brute_force(mdl, least):
    """Numbers of more values than there are phones: what they decide is asked, and the phones too."""
    generator = np.random.default_rng(6)
    contexts = np.column_stack([generator.integers(0, len(PHONES), (60, 3)), generator.integers(0, 9, (60, 2))])
    contexts = np.unique(contexts, axis=0)
    centre = np.stack([2.0 * (contexts[:, 1] == 1), 3.0 * (contexts[:, 3] > 6)], axis=1)
    frames = [generator.normal(mean, 0.5, size=(generator.integers(5, 12), 2)) for mean in centre]
    factors = Factor("words", 9), Factor("syllables", 9)
    asked = questions(PHONES, 3, 1, factors)
    tying = grow(cases_of(contexts, frames), asked, len(PHONES), 1, 1, FLOOR, least, mdl, factors=factors)
    expected = plain_tree(contexts, frames, asked, least, mdl * 2 * np.log(sum(map(len, frames))))
    found = tying.find(contexts)[:, 0]
    leaves = [sorted(map(tuple, contexts[found == leaf].tolist())) for leaf in range(tying.gaussians)]
    assert sorted(leaves) == sorted(expected) and tying.layout == ContextLayout(3, 1, 1, factors)
    assert {1, 3} <= set(tying.positions.tolist()) and (mdl < 1 or tying.gaussians == 3)
