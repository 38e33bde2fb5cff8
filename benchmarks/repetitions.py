"""How much two takes of the same words differ: what no model of words and times can predict of a finished run's faces.

Run: python -m benchmarks.repetitions RESULTS EXPERIMENT [MODEL ...]

RESULTS is a corpus's folder (results/grid), EXPERIMENT a folder in it. A word of a test utterance is compared with
every other take of it in the corpus, between the same two neighbours and spoken with the same phones, brought to its
times phone by phone. With noise of its own in each take, half the mean squared difference of two takes is the noise's
variance; where takes differ in how they were said, it is an estimate from above. Printed are its root and beside it the
root mean square errors of MODELs on the same frames (appearance parameters, not the mean over frames of Eq. 18), the
share of the models' squared error that is noise, and by how much the error could still fall; with 95 % intervals over
utterances. Then RMSE(appearance) (Eq. 18) of the frames in silence and in speech apart.
"""

import sys
from collections import defaultdict
from pathlib import Path

import numpy as np

from benchmarks.runs import alignment_files
from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.evaluation.metrics import frame_rmse
from visualspeech.features.contexts import read_phones
from visualspeech.features.resampling import at_times
from visualspeech.speech.alignment import Alignment, read_alignments
from visualspeech.speech.phones import SILENCE
from visualspeech.storage import ArrayCollection
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


def main(results: str, experiment: str, *models: str) -> None:
    corpus, run = Path(results), Path(results, experiment)
    utterances = read_utterances(run / "utterances.tsv")
    aligned = {name: found for path in alignment_files(corpus) for name, found in read_alignments(path).items()}
    takes = defaultdict(list)
    for one in utterances:
        for key, borders in takes_of(aligned[one.id]):
            takes[key].append((one.id, borders))
    models = models or tuple(sorted(path.parent.name for path in run.glob("models/*/predictions.h5")))
    with ArrayCollection(sorted((run / "features").glob("*.h5"))) as features:
        predictions = {name: ArrayCollection([run / "models" / name / "predictions.h5"]) for name in models}
        sums = []  # An utterance a row: noise, squared error of each model, frames.
        for one in of_split(utterances, "test"):
            truth, rate = np.float64(features.array(one.id, "appearance")), features.rate(one.id)
            times, total = frame_times(len(truth), rate), np.zeros(2 + len(models))
            for key, borders in takes_of(aligned[one.id]):
                others = [(name, theirs) for name, theirs in takes[key] if name != one.id]
                frames = (times >= borders[0]) & (times < borders[-1])
                if not others or not frames.any():
                    continue
                warped = [
                    at_times(np.float64(features.array(name, "appearance")), features.rate(name), moved)
                    for name, theirs in others
                    for moved in [np.interp(times[frames], borders, theirs)]
                ]
                total[0] += ((np.array(warped) - truth[frames]) ** 2).mean(axis=(0, 2)).sum() / 2
                for column, name in enumerate(models, start=1):
                    predicted = predictions[name].array(one.id, "appearance")[frames]
                    total[column] += ((predicted - truth[frames]) ** 2).mean(axis=1).sum()
                total[-1] += frames.sum()
            sums.append(total)
    sums = np.array([row for row in sums if row[-1]])
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
    by_speech(run, of_split(utterances, "test"), models)


def by_speech(run: Path, utterances, models) -> None:
    """Print RMSE(appearance) of frames in silence and in speech."""
    phones = read_phones(run / "phones.tsv")
    with ArrayCollection(sorted((run / "features").glob("*.h5"))) as features:
        truth = [features.array(one.id, "appearance") for one in utterances]
        labels = np.concatenate([features.array(one.id, "labels") for one in utterances])
    silent = labels[:, 1] == phones.index(SILENCE)
    print(f"{silent.mean():.0%} of {len(silent)} frames are silence")
    for name in models:
        with ArrayCollection([run / "models" / name / "predictions.h5"]) as predictions:
            pairs = zip(utterances, truth, strict=True)
            errors = np.concatenate([frame_rmse(predictions.array(u.id, "appearance"), v) for u, v in pairs])
        print(f"{name}: {errors[silent].mean():.2f} in silence, {errors[~silent].mean():.2f} in speech")


if __name__ == "__main__":
    main(*sys.argv[1:])
