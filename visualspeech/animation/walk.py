"""An endless sequence of frames from a few recorded seconds, without a visible jump (Schoedl et al. 2000).

Frames are played forwards and backwards. Before a recording ends, the sequence reverses its direction or jumps to
another position, in the same or in another recording, where the frames look similar. Every transition is a cross-fade
over some frames: a movement that is reversed comes to rest first, and the remaining distance is spread over the frames.
The cost of a transition is the mean distance over these frames, which avoids positions with fast head movement or a
blink. Transitions after which the speaker would soon blink again are avoided too, for example a reversal just after a
blink.

A. Schoedl, R. Szeliski, D. Salesin and I. Essa, "Video textures", SIGGRAPH 2000.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from visualspeech.errors import DataError
from visualspeech.fields import MAX_SEED, Settings, setting


class Mix(NamedTuple):
    """One frame of the sequence: ``frame`` mixed with ``other``, whose share is ``share`` (0 to 1)."""

    frame: int
    other: int
    share: float


@dataclass(frozen=True)
class WalkSettings(Settings):
    """Endless background from a few recorded seconds.

    The cost of a transition is the mean distance of the frames that are mixed; an ordinary step between frames is 2.
    One of the invisible transitions is chosen at random, because repetition is noticed; if there is none, the cheapest.
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
        "Minimum time between two blinks around a transition, in seconds, where possible.",
        minimum=0,
        maximum=3600,
    )
    seed: int = setting(0, "Seed of the choice among invisible transitions.", minimum=0, maximum=MAX_SEED)


def transition_costs(distances: np.ndarray, clip: np.ndarray, mixed: int) -> tuple[np.ndarray, np.ndarray]:
    """Costs of the transitions between all pairs of frames.

    Parameters
    ----------
    distances : (n, n) between frames
    clip : (n,) recording of each frame, ascending
    mixed : frames on each side of a transition

    Returns
    -------
    same, turned : (n, n) cost of a transition from frame i to frame j that keeps or reverses the direction: the mean
        distance over the 2 ``mixed`` + 1 frames around, infinite if a recording ends within them. Both hold for playing
        forwards and backwards.
    """
    count = len(distances)
    first, last = np.searchsorted(clip, clip), np.searchsorted(clip, clip, side="right") - 1
    frames = np.arange(count)
    inside = (frames - first >= mixed) & (last - frames >= mixed)
    result = []
    for sign in (1, -1):
        total = np.zeros((count, count))
        for step in range(-mixed, mixed + 1):
            total += distances[np.ix_(_clipped(frames + step, count), _clipped(frames + sign * step, count))]
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
    """Yield frames of the background endlessly.

    Parameters
    ----------
    distances : (n, n), of :func:`visualspeech.animation.background.frame_distances`
    clip : (n,) recording of each frame, ascending
    rate : frame rate in Hz
    closed : (n,) bool, frames in which the eyes are closed; default: none

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
    # A transition needs `mixed` frames on each side, and the interval to the next one fits three times into the longest
    # recording, so there is always a possible target.
    mixed = min(round(settings.crossfade * rate), (longest - 3) // 8)
    same, turned = transition_costs(distances, clip, mixed)
    min_interval = max(min(round(settings.min_interval * rate), (longest - 2 * mixed) // 3), 2 * mixed + 1)
    generator = np.random.default_rng(settings.seed)
    used = np.zeros(len(clip))
    closed = np.zeros(len(clip), bool) if closed is None else closed
    until = {sign: _frames_until_blink(closed, clip, sign) for sign in (1, -1)}
    blink_interval = settings.min_blink_interval * rate
    blinked = np.inf  # frames since the last blink
    # Begin at the beginning of the longest recording.
    at, direction = int(first[np.argmax(last - first)]), 1
    since = 0
    while True:
        end = last[at] if direction > 0 else first[at]
        ahead = np.arange(at + direction * max(min_interval - since, mixed), end + direction, direction)
        past, min_gap = _blinks_along(closed[np.arange(at, end + direction, direction)], blinked)
        steps = abs(ahead - at)
        gaps = [np.minimum(min_gap[steps, None], past[steps, None] + until[sign]) for sign in (direction, -direction)]
        costs = [cost[ahead] * (1 + 0.2 * used) for cost in (same, turned)]
        room = min_interval + mixed
        leave, to, turn = _choice(ahead, direction, costs, gaps, first, last, room, blink_interval, settings, generator)
        entered = closed[np.arange(to, to + turn * (mixed + 1), turn)]
        blinked = _blinks_along(entered, past[abs(leave - at)])[0][-1]
        used *= 0.7
        used[max(to - mixed, 0) : to + mixed + 1] += 1
        for frame in range(at, leave - direction * mixed, direction):
            yield Mix(frame, frame, 0.0)
        for step in range(-mixed, mixed + 1):
            share = (step + mixed + 1) / (2 * mixed + 2)
            yield Mix(leave + direction * step, to + turn * step, share * share * (3 - 2 * share))
        at, direction, since = to + turn * (mixed + 1), turn, mixed + 1


def _choice(
    ahead, direction, costs, gaps, first, last, room, blink_interval, settings, generator
) -> tuple[int, int, int]:
    """The next transition: frame to leave, frame to continue with, and direction (1 or -1) after it."""
    frames = np.arange(len(first))
    left = (last - frames), (frames - first)
    signs = direction, -direction
    table = np.stack([np.where(left[sign < 0] >= room, cost, np.inf) for sign, cost in zip(signs, costs, strict=True)])
    chosen = np.argwhere(table <= max(settings.visibility_threshold, 1.1 * table.min()))
    # Of the invisible transitions, those without an early blink, or else with the latest blink.
    gap = np.stack(gaps)[tuple(chosen.T)]
    chosen = chosen[gap >= min(blink_interval, 0.9 * gap.max())]
    turned, row, to = chosen[generator.integers(len(chosen))]
    return int(ahead[row]), int(to), int(signs[turned])


def _blinks_along(closed: np.ndarray, blinked: float) -> tuple[np.ndarray, np.ndarray]:
    """For each frame of a path, frames since the eyes were last closed, and the smallest gap between two blinks so far.

    Parameters
    ----------
    closed : (k,) bool, whether the eyes are closed
    blinked : frames since the last blink before the path
    """
    since, gaps, gap = np.empty(len(closed)), np.empty(len(closed)), np.inf
    for step, shut in enumerate(closed):
        if shut and blinked > 0:
            gap = min(gap, blinked + 1)
        blinked = 0 if shut else blinked + 1
        since[step], gaps[step] = blinked, gap
    return since, gaps


def _frames_until_blink(closed: np.ndarray, clip: np.ndarray, direction: int) -> np.ndarray:
    """Frames (n,) from each frame to the next one with closed eyes in one direction; infinite if there is none."""
    result = np.full(len(closed), np.inf)
    order = range(len(closed))[::-direction]
    for before, frame in zip([None, *order], order, strict=False):
        if closed[frame]:
            result[frame] = 0
        elif before is not None and clip[before] == clip[frame]:
            result[frame] = result[before] + 1
    return result


def _clipped(index: np.ndarray, count: int) -> np.ndarray:
    return np.clip(index, 0, count - 1)
