"""An endless way through a few recorded seconds without a visible jump.

Frames are played forwards and backwards. Before a recording ends, the way turns round or goes over to another place, of
the same or of another recording, where the frames look alike (A. Schodl et al. 2000, Video textures). Every change is
spread over some frames, in which the pictures of both ways are mixed: a movement that turns round comes to rest first,
and what distance is left is shared out. Places are chosen by the mean distance over these frames, so that a place where
the head turns fast, or blinks, is not chosen. Nor is one after which the speaker blinks again at once, as happens where
the way turns round behind a blink.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from visualspeech.errors import DataError
from visualspeech.fields import MAX_SEED, Settings, setting


class Mix(NamedTuple):
    """One frame of the way: ``frame``, or where ``share`` is above 0 a mixture with so much of ``other``."""

    frame: int
    other: int
    share: float


@dataclass(frozen=True)
class WalkSettings(Settings):
    """Endless background from a few recorded seconds.

    A transition costs the mean distance of the frames that are mixed, where an ordinary step from frame to frame is 2.
    Of all transitions that cannot be seen one is chosen at random, since repetition is noticed; where there is none,
    the best.
    """

    section = "walk"
    crossfade: float = setting(
        0.24, "Duration of the cross-fade on each side of a transition, in seconds.", minimum=0, maximum=60
    )
    min_interval: float = setting(
        1.2,
        "Minimum time between two transitions in seconds, where the recordings are long enough.",
        minimum=0,
        maximum=3600,
    )
    visibility_threshold: float = setting(
        6.0,
        "Frame distance up to which a transition counts as invisible (an ordinary step between frames is 2).",
        minimum=0,
        maximum=1_000_000,
    )
    min_blink_interval: float = setting(
        2.0,
        "Minimum time between two blinks that a transition may bring about, in seconds, where possible.",
        minimum=0,
        maximum=3600,
    )
    seed: int = setting(0, "Seed of the choice among invisible transitions.", minimum=0, maximum=MAX_SEED)


def changes(distances: np.ndarray, clip: np.ndarray, mixed: int) -> tuple[np.ndarray, np.ndarray]:
    """What it costs to go over from each frame to each other.

    Parameters
    ----------
    distances : (n, n) between frames
    clip : (n,) recording of each frame, ascending
    mixed : frames on each side of a change

    Returns
    -------
    same, turned : (n, n); the cost of going over from frame i to frame j, going on in the same direction or in the
        other: the mean distance over the 2 ``mixed`` + 1 frames around, infinite where a recording ends before. Both
        hold for either direction of time.
    """
    count = len(distances)
    first, last = np.searchsorted(clip, clip), np.searchsorted(clip, clip, side="right") - 1
    place = np.arange(count)
    inside = (place - first >= mixed) & (last - place >= mixed)
    result = []
    for sign in (1, -1):
        total = np.zeros((count, count))
        for step in range(-mixed, mixed + 1):
            total += distances[np.ix_(_clipped(place + step, count), _clipped(place + sign * step, count))]
        total /= 2 * mixed + 1
        total[~inside] = np.inf
        total[:, ~inside] = np.inf
        result.append(total)
    np.fill_diagonal(result[0], np.inf)
    return result[0], result[1]


def walk(
    distances: np.ndarray,
    clip: np.ndarray,
    rate: float,
    settings: WalkSettings | None = None,
    closed: np.ndarray | None = None,
) -> Iterator[Mix]:
    """Frames without end.

    Parameters
    ----------
    distances : (n, n), of :func:`visualspeech.animation.background.frame_distances`
    clip : (n,) recording of each frame, ascending
    rate : frames a second
    closed : (n,) bool, frames in which the eyes are closed; default: in none

    Raises
    ------
    DataError
        There is no frame.
    """
    settings = settings or WalkSettings()
    if not len(clip):
        raise DataError("there are no background frames to walk through.")
    first, last = np.searchsorted(clip, clip), np.searchsorted(clip, clip, side="right") - 1
    longest = int((last - first).max()) + 1
    if longest < 3:
        while True:
            yield Mix(0, 0, 0.0)
    # A change needs `mixed` frames on each side, and the way from one to the next fits three times into a recording:
    # so there always is a place to go over to.
    mixed = min(round(settings.crossfade * rate), (longest - 3) // 8)
    same, turned = changes(distances, clip, mixed)
    least = max(min(round(settings.min_interval * rate), (longest - 2 * mixed) // 3), 2 * mixed + 1)
    generator = np.random.default_rng(settings.seed)
    used = np.zeros(len(clip))
    closed = np.zeros(len(clip), bool) if closed is None else closed
    until = {way: _until(closed, clip, way) for way in (1, -1)}
    apart = settings.min_blink_interval * rate
    blinked = np.inf  # frames since the last blink
    # Begin where the recordings do, in the one with most room.
    at, direction = int(first[np.argmax(last - first)]), 1
    since = 0
    while True:
        end = last[at] if direction > 0 else first[at]
        ahead = np.arange(at + direction * max(least - since, mixed), end + direction, direction)
        past, least_gap = _blinks_along(closed[np.arange(at, end + direction, direction)], blinked)
        steps = abs(ahead - at)
        gaps = [np.minimum(least_gap[steps, None], past[steps, None] + until[way]) for way in (direction, -direction)]
        costs = [cost[ahead] * (1 + 0.2 * used) for cost in (same, turned)]
        leave, to, way = _choice(ahead, direction, costs, gaps, first, last, least + mixed, apart, settings, generator)
        entered = closed[np.arange(to, to + way * (mixed + 1), way)]
        blinked = _blinks_along(entered, past[abs(leave - at)])[0][-1]
        used *= 0.7
        used[max(to - mixed, 0) : to + mixed + 1] += 1
        for frame in range(at, leave - direction * mixed, direction):
            yield Mix(frame, frame, 0.0)
        for step in range(-mixed, mixed + 1):
            share = (step + mixed + 1) / (2 * mixed + 2)
            yield Mix(leave + direction * step, to + way * step, share * share * (3 - 2 * share))
        at, direction, since = to + way * (mixed + 1), way, mixed + 1


def _choice(ahead, direction, costs, gaps, first, last, room, apart, settings, generator) -> tuple[int, int, int]:
    """Where to leave, where to go over to, and in which direction to go on."""
    place = np.arange(len(first))
    left = (last - place), (place - first)
    ways = direction, -direction
    table = np.stack([np.where(left[way < 0] >= room, cost, np.inf) for way, cost in zip(ways, costs, strict=True)])
    chosen = np.argwhere(table <= max(settings.visibility_threshold, 1.1 * table.min()))
    # Of changes that cannot be seen, those without a blink that comes too soon, or where it comes latest.
    gap = np.stack(gaps)[tuple(chosen.T)]
    chosen = chosen[gap >= min(apart, 0.9 * gap.max())]
    kind, row, to = chosen[generator.integers(len(chosen))]
    return int(ahead[row]), int(to), int(direction if kind == 0 else -direction)


def _blinks_along(closed: np.ndarray, blinked: float) -> tuple[np.ndarray, np.ndarray]:
    """Along a path of frames: how many since the eyes were last closed, and the least gap between two blinks so far."""
    since, gaps, gap = np.empty(len(closed)), np.empty(len(closed)), np.inf
    for step, shut in enumerate(closed):
        if shut and blinked > 0:
            gap = min(gap, blinked + 1)
        blinked = 0 if shut else blinked + 1
        since[step], gaps[step] = blinked, gap
    return since, gaps


def _until(closed: np.ndarray, clip: np.ndarray, way: int) -> np.ndarray:
    """Frames from each frame to the next in which the eyes are closed, in one direction; infinite if there is none."""
    result = np.full(len(closed), np.inf)
    order = range(len(closed))[::-way]
    for before, frame in zip([None, *order], order, strict=False):
        if closed[frame]:
            result[frame] = 0
        elif before is not None and clip[before] == clip[frame]:
            result[frame] = result[before] + 1
    return result


def _clipped(index: np.ndarray, count: int) -> np.ndarray:
    return np.clip(index, 0, count - 1)
