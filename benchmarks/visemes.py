"""How well dynamic visemes are predicted from text, beside simpler ways and the visemes of the recorded face.

Run: python -m benchmarks.visemes RESULTS CODING [CLASSES HZ]

RESULTS is the folder of a finished run, for example results/grid, and CODING one of its visual codings, whose
parameters are brought to HZ (100). For each way, of the validation utterances: the share of the frames that have the
class of the recorded face; precision, recall and F1 of the boundaries of gestures, one counting as found within 20 ms;
the error of the means of the predicted classes, stretched to the predicted gestures, as a share of the error of the
training mean; and gestures per utterance.

- majority: the most frequent class of each triphone and third of a phone, with back-off, the mode of seven frames
- look-up: the mean parameters of each triphone and third of a phone, with back-off, cut and labelled like a recording
- regression: the parameters that the block dynamic_visemes predicts, cut and labelled like a recording
- predicted: the visemes of the block, whose classes are those of the best path

The last two lines are training utterances: cross-fitted, which is what networks learn from, and as the model of all
training utterances predicts them.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.command import run_main
from benchmarks.runs import CodingRun, CorpusRun
from visualspeech.features.blocks.base import Source
from visualspeech.features.blocks.dynamic_visemes import DynamicVisemes, DynamicVisemesSettings
from visualspeech.features.blocks.triphone_state import TriphoneState
from visualspeech.features.contexts import phone_inventory
from visualspeech.features.examples import Example
from visualspeech.features.resampling import resample
from visualspeech.features.visemes.segmentation import Gestures, gestures_of
from visualspeech.fields import with_defaults
from visualspeech.models import lookup
from visualspeech.models.rows import ModelRow
from visualspeech.models.task import Model, Task

TOLERANCE = 0.02  # seconds
MODE = 7  # frames
Visemes = Callable[[Source], tuple[Gestures, np.ndarray]]


def main(results: Path, coding: str, classes: int = 160, hz: float = 100.0) -> None:
    run = CodingRun(CorpusRun(results), coding)
    training, held_out = (sources_of(run, split, hz) for split in ("train", "validation"))
    phones = phone_inventory(one.alignment for one in training)
    block = DynamicVisemes.fit(with_defaults(DynamicVisemesSettings, {"classes": classes}), phones, training)
    oracle = replace_text(block)
    block_of_labels = TriphoneState.fit({"fractional": False, "states": "thirds"}, phones, ())
    parameters = look_up(block_of_labels, training, lambda one: one.parameters)
    shares = look_up(block_of_labels, training, lambda one: np.eye(classes)[of_frames(oracle.visemes(one))])

    def labels(one: Source):
        return [next(block_of_labels.encode([one]))]

    def cut(values: np.ndarray) -> tuple[Gestures, np.ndarray]:
        gestures = gestures_of(values, hz, block.options.smoothing, block.options.min_length)
        return gestures, block.classes.assign(values, gestures)

    ways: dict[str, tuple[Sequence[Source], Visemes]] = {
        "oracle": (held_out, oracle.visemes),
        "majority": (held_out, lambda one: runs_of(mode(shares.predict(labels(one)).argmax(axis=1)))),
        "look-up": (held_out, lambda one: cut(parameters.predict(labels(one)))),
        "regression": (held_out, lambda one: cut(block.text.predict(one.alignment, one.frames, hz, phones)[0])),
        "predicted": (held_out, block.visemes),
        "predicted, training, cross-fitted": (training, block.visemes),
        "predicted, training, known": (training, lambda one: block.visemes(replace(one, id=""))),
    }
    mean = np.concatenate([one.parameters for one in training]).mean(axis=0)
    for name, (sources, visemes) in ways.items():
        print(f"{name:34}{measured(block, oracle, mean, sources, visemes)}", flush=True)


def sources_of(run: CodingRun, split: str, hz: float) -> list[Source]:
    """The utterances of a split whose faces were coded."""
    found = []
    with run.parameters() as parameters:
        for name in run.corpus.ids(split):
            if name in parameters:
                values = resample(parameters.array(name, "appearance"), parameters.rate(name), hz)
                alignment = run.corpus.alignments[name]
                found.append(Source(len(values), hz, alignment, parameters=values, id=name))
    return found


def replace_text(block: DynamicVisemes) -> DynamicVisemes:
    """The block that reads the same visemes of the recorded face."""
    return DynamicVisemes(block.phones, block.classes, replace(block.options, source="oracle"))


def look_up(block: TriphoneState, training: Sequence[Source], target: Callable[[Source], np.ndarray]) -> Model:
    """Means of a target (T, N) of each triphone and third of a phone."""
    examples = [
        Example((next(block.encode([one])),), np.asarray(target(one), np.float32), one.rate) for one in training
    ]
    row = ModelRow("lookup", "look-up", "lookup", {"context": "triphone", "min_count": 5}, ("labels",))
    return lookup.fit(Task(row, {"labels": block}, examples, examples)).model


def of_frames(visemes: tuple[Gestures, np.ndarray]) -> np.ndarray:
    """Class of each frame."""
    gestures, classes = visemes
    return classes[gestures.of_frames()]


def mode(classes: np.ndarray) -> np.ndarray:
    """The most frequent class of each frame and those around it."""
    padded = np.pad(classes, MODE // 2, mode="edge")
    return np.array([np.bincount(around).argmax() for around in np.lib.stride_tricks.sliding_window_view(padded, MODE)])


def runs_of(classes: np.ndarray) -> tuple[Gestures, np.ndarray]:
    """Frames of one class as gestures."""
    starts = np.concatenate([[0], np.flatnonzero(np.diff(classes)) + 1])
    return Gestures(starts, len(classes)), classes[starts]


def measured(
    block: DynamicVisemes, oracle: DynamicVisemes, mean: np.ndarray, sources: Sequence[Source], visemes: Visemes
) -> str:
    """The figures of one way as a line."""
    same = frames = found = right = made = 0
    error = base = 0.0
    for one in sources:
        own, true = visemes(one), oracle.visemes(one)
        same += (of_frames(own) == of_frames(true)).sum()
        frames += one.frames
        found += matches(own[0].starts[1:], true[0].starts[1:], round(TOLERANCE * one.rate))
        made, right = made + len(own[0].starts) - 1, right + len(true[0].starts) - 1
        error += np.square(block.classes.reconstruct(own[1], own[0]) - one.parameters).sum()
        base += np.square(one.parameters - mean).sum()
    precision, recall = found / max(made, 1), found / max(right, 1)
    together = 2 * precision * recall / max(precision + recall, 1e-9)
    return (
        f"frames {same / frames:.3f}  boundaries {precision:.3f} {recall:.3f} {together:.3f}  "
        f"error {np.sqrt(error / base):.3f}  gestures {made / len(sources) + 1:.1f}"
    )


def matches(predicted: np.ndarray, true: np.ndarray, tolerance: int) -> int:
    """Number of boundaries that are found, each by one predicted boundary at most."""
    left, count = list(true), 0
    for at in predicted:
        near = [other for other in left if abs(other - at) <= tolerance]
        if near:
            left.remove(min(near, key=lambda other: abs(other - at)))
            count += 1
    return count


if __name__ == "__main__":
    run_main(main, __doc__)
