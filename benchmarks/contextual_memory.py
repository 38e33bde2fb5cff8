"""Memory of training on contextual features of a long corpus, and the time of an epoch from a part of one.

Run: python -m benchmarks.contextual_memory [HOURS] [UPDATES] [NODES] [BATCH]

A simulated corpus of HOURS (14) at 100 frames per second with the inputs of `gathered` and 90 outputs. A network of
three hidden layers of NODES units (512) is trained as in a run, with UPDATES (30) mini-batches of BATCH frames (1,024).
Prints the bytes of the corpus in memory, the peak of the process, and the time of an epoch of all frames. A run keeps
up to 256 MB of its feature files in addition.
"""

import time
from itertools import islice
from unittest import mock

from benchmarks.command import run_main
from benchmarks.contextual import RATE, Corpus, task
from benchmarks.memory import peak_megabytes
from visualspeech.models import dnn
from visualspeech.models.frames import FrameStore

FRAMES = 1000  # of an utterance


def peak() -> float:
    """Largest memory of this process so far in GB."""
    return peak_megabytes() * 2**20 / 1e9


def main(hours: float = 14, updates: int = 30, nodes: int = 512, batch: int = 1024) -> None:
    count, before = max(round(hours * 3600 * RATE / FRAMES), 1), peak()
    learned, marks = Corpus(count, FRAMES), []
    batches = FrameStore.batches

    def part(store: FrameStore, size: int):
        arrays = (store.index, store.values, store.targets)
        print(f"{len(store.targets):,} frames in {sum(one.nbytes for one in arrays) / 1e9:.2f} GB", flush=True)
        for given in islice(batches(store, size), updates):
            marks.append((time.perf_counter(), time.process_time()))
            yield given
        marks.append((time.perf_counter(), time.process_time()))

    settings = {"layers": 3, "nodes": nodes}
    given = task(settings, {"max_epochs": 1, "batch_frames": batch}, learned, Corpus(2, FRAMES, seed=2))
    begin = time.process_time()
    with mock.patch.object(FrameStore, "batches", part):
        dnn.fit(given)
    wall, processor = (last - first for first, last in zip(marks[0], marks[-1], strict=True))
    frames = batch * (len(marks) - 1)
    epoch = count * FRAMES / frames / 60
    print(f"peak memory {peak():.2f} GB, of which {before:.2f} GB before the corpus was read")
    print(f"check, digest and copy of the corpus: {marks[0][1] - begin:.0f} s of processor time")
    print(
        f"3 x {nodes} units, {batch:,} frames per update: {frames / processor:,.0f} frames/s of processor time; "
        f"an epoch of all frames {processor * epoch:.0f} minutes ({wall * epoch:.0f} by the clock)"
    )


if __name__ == "__main__":
    run_main(main, __doc__)
