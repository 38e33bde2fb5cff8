from itertools import islice

import numpy as np
import pytest

from visualspeech.animation.walk import Mix, WalkSettings, transition_costs, walk
from visualspeech.errors import DataError, SettingError


def path_of(values, clip=None, frames=2000, rate=25.0, **settings):
    """A way through frames that show some values (n, d), and what it shows."""
    values = np.asarray(values, float)
    distances = np.linalg.norm(values[:, None] - values[None], axis=2)
    step = np.median(distances[np.arange(len(values) - 1), np.arange(1, len(values))]) if len(values) > 1 else 1.0
    distances *= 2 / step
    clip = np.zeros(len(values), int) if clip is None else clip
    way = list(islice(walk(distances, clip, rate, WalkSettings(**settings)), frames))
    share = np.array([mix.share for mix in way])[:, None]
    shown = (1 - share) * values[[mix.frame for mix in way]] + share * values[[mix.other for mix in way]]
    return way, shown


@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, 10, 11, 12, 19, 30, 75, 200])
def test_recordings_of_any_length_go_on_for_ever(count):
    way, _ = path_of(np.random.default_rng(0).normal(size=(count, 2)).cumsum(axis=0))
    assert len(way) == 2000
    for mix in way:
        assert 0 <= mix.frame < count and 0 <= mix.other < count and 0 <= mix.share < 1
    if count >= 3:
        assert len({mix.frame for mix in way}) >= count / 3


def test_frames_follow_each_other_except_where_they_are_mixed():
    way, _ = path_of(np.random.default_rng(1).normal(size=(75, 3)).cumsum(axis=0))
    for before, after in zip(way, way[1:], strict=False):
        shown = {before.frame, before.other} if before.share else {before.frame}
        assert any(abs(after.frame - frame) == 1 for frame in shown)


def test_there_is_no_jump():
    """A slow head movement: no step of the way is much larger than the steps of the recordings."""
    generator = np.random.default_rng(2)
    time = np.arange(90)[:, None] / 25
    heads = [np.sin(2 * np.pi * (0.3 * time + generator.uniform(size=4))) for _ in range(3)]
    values = np.concatenate(heads)
    clip = np.repeat([0, 1, 2], 90)
    _, shown = path_of(values, clip, 5000)
    recorded = np.concatenate([np.linalg.norm(np.diff(head, axis=0), axis=1) for head in heads])
    steps = np.linalg.norm(np.diff(shown, axis=0), axis=1)
    assert steps.max() < 1.25 * recorded.max()
    # Nor is a movement thrown round: it takes several frames to turn.
    bends = np.linalg.norm(np.diff(shown, 2, axis=0), axis=1)
    assert bends.max() < 0.5 * recorded.max()


def test_it_does_not_turn_in_a_blink():
    """Frames 40 to 44 look unlike all others; no change touches them."""
    values = np.zeros((75, 1))
    values[40:45] = 9
    values += np.random.default_rng(3).normal(0, 0.01, values.shape)
    way, _ = path_of(values)
    assert not [mix for mix in way if mix.share and (40 <= mix.frame < 45) != (40 <= mix.other < 45)]
    assert [mix for mix in way if 40 <= mix.frame < 45]  # but it is seen


def test_another_recording_is_used_where_it_fits_and_not_where_it_does_not():
    generator = np.random.default_rng(4)
    values = generator.normal(size=(120, 2))
    clip = np.repeat([0, 1], 60)
    near, _ = path_of(values, clip)
    assert len({clip[mix.frame] for mix in near}) == 2
    far, _ = path_of(values + 100 * clip[:, None], clip)
    assert len({clip[mix.frame] for mix in far}) == 1


def test_the_same_seed_takes_the_same_way():
    values = np.random.default_rng(5).normal(size=(60, 2)).cumsum(axis=0)
    assert path_of(values, seed=1)[0] == path_of(values, seed=1)[0]
    assert path_of(values, seed=1)[0] != path_of(values, seed=2)[0]


def test_costs_are_the_mean_distance_along_both_ways():
    distances = np.random.default_rng(6).uniform(size=(20, 20))
    clip = np.repeat([0, 1], 10)
    same, turned = transition_costs(distances, clip, 2)
    assert same[4, 13] == pytest.approx(np.mean([distances[4 + s, 13 + s] for s in range(-2, 3)]))
    assert turned[4, 13] == pytest.approx(np.mean([distances[4 + s, 13 - s] for s in range(-2, 3)]))
    assert np.isinf(same[4, 11]) and np.isinf(same[9, 4]) and np.isinf(same[4, 4]) and np.isfinite(turned[4, 4])


def test_bad_settings():
    with pytest.raises(SettingError, match="crossfade"):
        WalkSettings(crossfade=-1)
    with pytest.raises(SettingError, match="visibility_threshold"):
        WalkSettings(visibility_threshold=-1)
    with pytest.raises(DataError, match="no background"):
        next(walk(np.zeros((0, 0)), np.zeros(0, int), 25.0))
    assert next(walk(np.zeros((1, 1)), np.zeros(1, int), 25.0)) == Mix(0, 0, 0.0)


def test_eyes_do_not_close_again_at_once():
    """Of two recordings with a blink in the middle: a way that may turn round anywhere would double it."""
    distances = np.full((150, 150), 2.0)
    clip, closed = np.repeat([0, 1], 75), np.zeros(150, bool)
    closed[[35, 36, 110, 111]] = True

    def gaps(**settings):
        way = list(islice(walk(distances, clip, 25.0, WalkSettings(**settings), closed), 5000))
        shut = np.array([closed[mix.other if mix.share > 0.5 else mix.frame] for mix in way])
        return np.diff(np.flatnonzero(np.diff(shut.astype(int)) == 1)) / 25

    assert np.mean(gaps(min_blink_interval=0.0) < 1.5) > 0.2
    assert np.mean(gaps() < 1.2) < 0.02
    assert gaps().max() < 15
