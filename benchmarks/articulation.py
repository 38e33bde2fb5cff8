"""Articulation of a speaker in free text: sentences whose words and sounds no recording holds in that order.

Run: python -m benchmarks.articulation RESULTS SYSTEM [MODEL ...]

RESULTS is the folder of a corpus (results/grid), SYSTEM a system that was run on it, MODELs some of its trained models
(all). The 200 sentences of benchmarks/free_text.txt are spoken as by `visualspeech
speak`, without rendering: phones and times of eSpeak NG, the model's prediction, the face at rest in pauses. For each
model prints the closure rates (:mod:`visualspeech.evaluation.articulation`) of p, b, m and f, v by the thresholds of
the recorded training utterances, for each phone, and for known and unknown triphones; the standard deviation of the
lip opening in speech over that of the recorded training utterances; and beside them the closure rates of the recorded
and predicted test utterances.
"""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from benchmarks.command import run_main
from benchmarks.runs import CorpusRun, SystemRun
from visualspeech.animation.performance import perform
from visualspeech.errors import DataError
from visualspeech.evaluation.articulation import Target, targets_of
from visualspeech.face.coding_files import load_coding
from visualspeech.face.lips import lip_opening
from visualspeech.face.point_sets import to_points
from visualspeech.models.inventory import phones_of
from visualspeech.models.rest import resting_face
from visualspeech.models.task import Model
from visualspeech.provenance import file_digest
from visualspeech.speech.alignment import Alignment, silent_frames
from visualspeech.speech.closures import CLOSURES, occurrences
from visualspeech.speech.phones import SILENCE
from visualspeech.speech.spoken import Spoken, speak_text, state_shares
from visualspeech.speech.substitutes import in_phones

TEXT = Path(__file__).with_name("free_text.txt")
Opened = tuple[np.ndarray, Alignment, float]  # opening (T,), alignment, frame rate in Hz


def triphones_of(alignment: Alignment) -> list[tuple[str, str, str]]:
    """Left neighbour, phone and right neighbour of each phone; silence beyond the ends."""
    labels = [SILENCE, *(phone.label for phone in alignment.phones), SILENCE]
    return list(zip(labels, labels[1:], labels[2:], strict=False))


def closed(opened: Iterable[Opened], closures: Sequence[Target]) -> list[tuple[str, str, tuple, bool]]:
    """Class, phone, triphone and whether the lips close, of every occurrence."""
    return [
        (
            one.name,
            alignment.phones[number].label,
            triphones_of(alignment)[number],
            bool(opening[frame] <= one.threshold),
        )
        for opening, alignment, rate in opened
        for one in closures
        for number, frame in occurrences(opening, alignment, rate, one.name)
    ]


def in_speech(opened: Iterable[Opened]) -> np.ndarray:
    """Openings of all frames that lie in no pause."""
    return np.concatenate([opening[~silent_frames(spoken, len(opening), rate)] for opening, spoken, rate in opened])


def rates(found: Iterable[tuple[str, bool]]) -> str:
    """Share of those that are true by name, with their number."""
    groups = defaultdict(list)
    for name, value in found:
        groups[name].append(value)
    return ", ".join(f"{name} {np.mean(values):.3f} ({len(values)})" for name, values in sorted(groups.items()))


def spoken_openings(spoken: Sequence[Spoken], model: Model, rest: np.ndarray, coding) -> list[Opened]:
    """The opening of the lips in each sentence, as `speak` would show it."""
    found = []
    for one in spoken:
        appearance = perform([one], model, rest).appearance
        opening = lip_opening(coding.decode_points(appearance[: len(appearance)]), coding.points)
        # In the model's own phones, as it is told them.
        found.append((opening, in_phones(one.alignment, phones_of(model))[0], model.rate))
    return found


def coding_of(run: SystemRun, model: str):
    """The visual coding whose parameters a model predicts.

    Raises
    ------
    DataError
        The run has no such coding.
    """
    wanted = run.model(model).coding
    for path in sorted(run.corpus.folder.glob("codings/*/model.safetensors")):
        if file_digest(path) == wanted:
            return load_coding(path)
    raise DataError(f"{run.corpus.folder} lacks the visual coding that {model} was trained for.")


def main(results: Path, system: str, *models: str) -> None:
    run = SystemRun(CorpusRun(results), system)
    names = models or run.trained_models()
    coding = coding_of(run, names[0])
    aligned, training, test = run.corpus.alignments, run.corpus.ids("train"), run.corpus.ids("test")
    shares = state_shares(aligned[name] for name in training)
    spoken = [one for line in TEXT.read_text().splitlines() for one in speak_text(line, shares=shares)]
    known = {triphone for name in training for triphone in triphones_of(aligned[name])}
    with run.targets() as targets:

        def recorded(names: Sequence[str]) -> list[Opened]:
            return [
                (lip_opening(to_points(targets.array(name, "points")), coding.points), aligned[name],
                 targets.rate(name)) for name in names
            ]  # fmt: skip

        shown = recorded(training)
        rest = resting_face(
            lambda: ((aligned[name], targets.array(name, "appearance"), targets.rate(name)) for name in training)
        )
        tested = recorded(test)
    closures = [one for one in targets_of(shown) if one.name in CLOSURES]
    limits = ", ".join(f"{CLOSURES[one.name]}: {one.threshold:.2f} px" for one in closures)
    print(f"{len(spoken)} sentences; closed up to ({limits})")
    print(f"recorded test utterances: {rates((name, shut) for name, _, _, shut in closed(tested, closures))}")
    for name in names:
        free = spoken_openings(spoken, run.model(name), rest, coding)
        found = closed(free, closures)
        with run.predictions(name) as predictions:
            predicted = [
                (lip_opening(coding.decode_points(predictions.array(one, "appearance")), coding.points), *others)
                for one, (_, *others) in zip(test, tested, strict=True)
            ]
        print(f"{name}, test utterances: {rates((kind, shut) for kind, _, _, shut in closed(predicted, closures))}")
        print(f"{name}, free text: {rates((kind, shut) for kind, _, _, shut in found)}")
        print(f"  by phone: {rates((phone, shut) for _, phone, _, shut in found)}")
        words = {True: "known triphone", False: "unknown triphone"}
        print(f"  by context: {rates((f'{kind} {words[tri in known]}', shut) for kind, _, tri, shut in found)}")
        ratio = in_speech(free).std() / in_speech(shown).std()
        print(f"  opening in speech: deviation {ratio:.3f} of that of the recorded training utterances")


if __name__ == "__main__":
    run_main(main, __doc__)
