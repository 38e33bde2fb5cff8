"""Processor time of training each network of Table 2, and what all of them cost on a corpus of a given size.

Run: python -m benchmarks.topologies [FRAMES [EPOCHS]]

FRAMES is the size of the training set (default 23550: GRID 400), EPOCHS the length of each training (40). One epoch of
each stack and width over the same synthetic utterances, the faster of two, on one thread; processor time, so that other
work on the machine matters little. Utterances have 75 frames, labels 3 x 32 + 3 entries, faces 80 parameters. Prints
for each stack: microseconds per frame and epoch at 128, 256 and 512 nodes, and weights in thousands; then the hours of
all 42 networks for the given training set.
"""

import time

from benchmarks.command import run_main
from benchmarks.synthetic import block, examples, task
from visualspeech.evaluation.published_results import published
from visualspeech.models.stack import Stack, fit
from visualspeech.models.stack_settings import StackSettings

UTTERANCES, FRAMES, PHONES, OUTPUTS = 32, 75, 32, 80


def microseconds(letters: str, nodes: int, utterances) -> float:
    """Processor time of an epoch with its validation on a tenth, per training frame."""
    times = []
    for _ in range(2):
        begin = time.process_time()
        fit(task({"letters": letters, "nodes": nodes}, {"max_epochs": 1}, PHONES, utterances, utterances[:3]))
        times.append(time.process_time() - begin)
    return 1e6 * min(times) / (UTTERANCES * FRAMES)


def main(frames: int = 23_550, epochs: int = 40) -> None:
    paper, utterances = published("fan2015"), examples(UTTERANCES, FRAMES, PHONES, OUTPUTS)
    microseconds("F", 16, utterances)
    total = dict.fromkeys(paper.nodes, 0.0)
    for letters in sorted(paper.stacks, key=lambda name: (len(name), name)):
        row = []
        for nodes in paper.nodes:
            found = microseconds(letters, nodes, utterances)
            stack = Stack(StackSettings(letters, nodes), [block(PHONES).layout], OUTPUTS)
            weights = sum(values.numel() for values in stack.parameters())
            total[nodes] += found
            row.append(f"{found:8.0f} us {weights / 1000:6.0f}k")
        print(f"{letters:4}", *row, flush=True)
    for nodes, found in total.items():
        print(f"14 networks of {nodes} nodes: {1e-6 * found * frames * epochs / 3600:.2f} hours of one core")
    whole = 1e-6 * sum(total.values()) * frames * epochs / 3600
    print(
        f"all {len(paper.stacks) * len(paper.nodes)}, {frames} frames, {epochs} epochs: {whole:.2f} hours of one core"
    )


if __name__ == "__main__":
    run_main(main, __doc__)
