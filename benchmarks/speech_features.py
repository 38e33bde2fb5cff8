"""Speed of the speech features: seconds of sound per second of one core, for 27 and for 44 features.

Run: python -m benchmarks.speech_features [SECONDS] [ROUNDS]

Exits with status 1 if one is slower than 20 times real time.

Utterances of 3 s and one recording of SECONDS seconds (300) of synthetic speech (eSpeak, repeated), each ROUNDS times
(3), from the samples to the normalised features at 120 frames per second, on one thread. Time is processor time, which
other work on the machine changes little; the median is shown, and by how much the largest memory of the process grew.
The 44 features need the package opensmile.
"""

import sys
import time
from collections.abc import Callable

import numpy as np

from benchmarks.command import run_main
from benchmarks.memory import peak_megabytes
from visualspeech.features.blocks.base import Source, block_class, fit_block, unavailable
from visualspeech.fields import with_defaults
from visualspeech.speech.sound import RATE, Sound
from visualspeech.speech.tts import synthesise

VISUAL = 120.0  # Hz
TEXT = "The quick brown fox jumps over the lazy dog, and nobody at the river bank asks where it wants to go."
WANTED = 20  # times real time


def main(seconds: int = 300, rounds: int = 3) -> int:
    samples = speech(seconds)
    pieces = [samples[first : first + 3 * RATE] for first in range(0, min(len(samples), 90 * RATE), 3 * RATE)]
    slow = False
    print("| features | sound | times real time (1 core) | more memory, MB |\n|---|---|---:|---:|")
    for kind in ("speech27", "speech44"):
        if unavailable(block_class(kind)):
            print(f"{kind} is left out: {unavailable(block_class(kind))}", file=sys.stderr)
            continue
        block = fit_block(kind, with_defaults(block_class(kind).settings, {}), (), [source(pieces[0])])
        for name, sounds in (("30 utterances of 3 s", pieces), (f"one recording of {seconds} s", [samples])):
            before = peak_megabytes()
            length = sum(map(len, sounds)) / RATE
            # A speaker who is known, so that features are computed once.
            found = median(lambda: [list(block.encode([source(one)])) for one in sounds], rounds)  # noqa: B023
            slow |= length / found < WANTED
            print(f"| {kind} | {name} | {length / found:.0f} | {peak_megabytes() - before:.0f} |")
    return int(slow)


def source(samples: np.ndarray) -> Source:
    return Source(int(len(samples) / RATE * VISUAL), VISUAL, sound=Sound(samples), speaker="espeak")


def speech(seconds: float) -> np.ndarray:
    """Samples (n,) int16 at 16 kHz."""
    said = synthesise(TEXT)
    sound = Sound.of(said.samples / 32768, said.rate).samples
    return np.resize(sound, int(seconds * RATE))


def median(function: Callable[[], object], rounds: int) -> float:
    """Processor time of a call in seconds."""
    times = []
    for _ in range(rounds):
        begin = time.process_time()
        function()
        times.append(time.process_time() - begin)
    return float(np.median(times))


if __name__ == "__main__":
    run_main(main, __doc__)
