"""How much two takes of the same words differ: what no model of words and times can predict of the faces of a run.

Run: python -m benchmarks.repetitions RESULTS SYSTEM [MODEL ...]

RESULTS is the folder of a corpus (results/grid), SYSTEM a system that was run on it, MODELs some of its trained models
(all). A word of a test utterance is compared with every other take of it in the corpus, between the same two neighbours
and spoken with the same phones, aligned to it phone by phone. If each take has noise of its own, half the mean squared
difference of two takes is the variance of the noise; where takes differ in how they were said, it is an upper bound.
Prints its root and the root mean square errors of the models on the same frames (appearance parameters, not the mean
over frames of Eq. 18), the share of the models' squared error that is noise, and by how much the error could still
fall; with 95 % intervals over utterances. Then RMSE(appearance) (Eq. 18) of the frames in silence and in speech.
"""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path

import numpy as np

from benchmarks.command import run_main
from benchmarks.runs import CorpusRun, SystemRun
from visualspeech.evaluation.scoring import frame_rmse
from visualspeech.features.resampling import at_times
from visualspeech.speech.alignment import Alignment, silent_frames
from visualspeech.speech.phones import SILENCE
from visualspeech.timing import frame_times

DRAWS = 2000


def takes_of(alignment: Alignment) -> list[tuple[tuple, np.ndarray]]:
    """Inner words of an utterance: (left word, word, right word, phones), and its phones' borders in seconds."""
    words = [(number, word.label) for number, word in enumerate(alignment.words) if word.label != SILENCE]
    found, labels = [], [label for _, label in words]
    for position, (number, _) in enumerate(words[1:-1], start=1):
        phones = [phone for phone in alignment.phones if phone.parent == number]
        key = (*labels[position - 1 : position + 2], *(phone.label for phone in phones))
        found.append((key, np.array([*(phone.start for phone in phones), phones[-1].end])))
    return found


def main(results: Path, system: str, *models: str) -> None:
    run = SystemRun(CorpusRun(results), system)
    aligned = run.corpus.alignments
    takes = defaultdict(list)
    for utterance in run.corpus.utterances:
        for key, borders in takes_of(aligned[utterance.id]):
            takes[key].append((utterance.id, borders))
    models = models or tuple(run.trained_models())
    with ExitStack() as files:
        targets = files.enter_context(run.targets())
        predictions = {name: files.enter_context(run.predictions(name)) for name in models}
        sums = []  # One row per utterance: noise, squared error of each model, frames.
        for name in run.corpus.ids("test"):
            truth, rate = np.float64(targets.array(name, "appearance")), targets.rate(name)
            times, total = frame_times(len(truth), rate), np.zeros(2 + len(models))
            for key, borders in takes_of(aligned[name]):
                others = [(other, theirs) for other, theirs in takes[key] if other != name]
                frames = (times >= borders[0]) & (times < borders[-1])
                if not others or not frames.any():
                    continue
                warped = [
                    at_times(np.float64(targets.array(other, "appearance")), targets.rate(other), moved)
                    for other, theirs in others
                    for moved in [np.interp(times[frames], borders, theirs)]
                ]
                total[0] += ((np.array(warped) - truth[frames]) ** 2).mean(axis=(0, 2)).sum() / 2
                for column, model in enumerate(models, start=1):
                    predicted = predictions[model].array(name, "appearance")[frames]
                    total[column] += ((predicted - truth[frames]) ** 2).mean(axis=1).sum()
                total[-1] += frames.sum()
            sums.append(total)
        silent = [
            silent_frames(aligned[name], targets.length(name, "appearance"), targets.rate(name))
            for name in run.corpus.ids("test")
        ]
        errors = {
            model: [
                frame_rmse(predictions[model].array(name, "appearance"), targets.array(name, "appearance"))
                for name in run.corpus.ids("test")
            ]
            for model in models
        }
    show_takes(np.array([row for row in sums if row[-1]]), models)
    show_silence(np.concatenate(silent), {model: np.concatenate(rows) for model, rows in errors.items()})


def show_takes(sums: np.ndarray, models: Sequence[str]) -> None:
    """Print the noise and the errors of the models, from their sums over frames by utterance."""
    if not len(sums):
        print("no word of a test utterance was said twice between the same words")
        return
    drawn = np.random.default_rng(1).integers(0, len(sums), (DRAWS, len(sums)))
    whole, sampled = sums.sum(axis=0), sums[drawn].sum(axis=1)
    print(f"{len(sums)} test utterances with a word that has another take, {whole[-1]:.0f} frames")
    low, high = np.quantile(np.sqrt(sampled[:, 0] / sampled[:, -1]), (0.025, 0.975))
    print(f"two takes of the same words: {np.sqrt(whole[0] / whole[-1]):.2f} [{low:.2f}, {high:.2f}]")
    for column, name in enumerate(models, start=1):
        left = np.quantile(1 - np.sqrt(sampled[:, 0] / sampled[:, column]), (0.025, 0.975))
        print(
            f"{name}: {np.sqrt(whole[column] / whole[-1]):.2f}, of its squared error "
            f"{whole[0] / whole[column]:.0%} is noise, the error could fall by "
            f"{1 - np.sqrt(whole[0] / whole[column]):.1%} [{left[0]:.1%}, {left[1]:.1%}]"
        )


def show_silence(silent: np.ndarray, errors: Mapping[str, np.ndarray]) -> None:
    """Print RMSE(appearance) of the frames in silence and in speech."""
    print(f"{silent.mean():.0%} of {len(silent)} frames are silence")
    for model, values in errors.items():
        print(f"{model}: {values[silent].mean():.2f} in silence, {values[~silent].mean():.2f} in speech")


if __name__ == "__main__":
    run_main(main, __doc__)
