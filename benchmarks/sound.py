"""Networks driven by sound: against those driven by labels, on other levels and channels, and on another voice.

Run: python -m benchmarks.sound RESULTS SYSTEM LABELS SOUND [MODELS ...]

RESULTS is the folder of a corpus (results/grid), SYSTEM a system that was run on it, LABELS a network that reads labels
(FBB-128), SOUND one that reads sound alone (FBB-128-mel); MODELS are further networks (FBB-128-tri-mel). Errors are of
centred trajectories: prediction and truth of each utterance less their own means over it. Prints

1. RMSE(appearance) and CORR (Eq. 18 and 19) of each network on the validation and the test utterances;
2. for the networks that read sound: the same of the test utterances at other levels, through filters, and in noise;
3. for the test utterances and for the synthetic voice reading their sentences: how far the trajectories of SOUND are
   from those of LABELS, which reads the true phones and times; how well the openings of the mouth agree; and the share
   of p, b and m in which the lips close, that is, in which the least opening is below the 90th percentile of the
   recorded speaker's.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from benchmarks.command import run_main
from benchmarks.runs import CodingRun, CorpusRun, SystemRun, shards
from visualspeech.animation.performance import in_phones_of
from visualspeech.evaluation.metrics import frame_correlation, frame_rmse
from visualspeech.face.aam.model import Aam
from visualspeech.features.blocks.base import Source
from visualspeech.models.inventory import needs_of_model, phones_of, predict_source
from visualspeech.models.task import Model
from visualspeech.speech.alignment import Alignment
from visualspeech.speech.sound import RATE, Sound, to_int16
from visualspeech.speech.spoken import speak_text, state_shares
from visualspeech.storage.arrays import ArrayCollection

CLOSED = ("p", "b", "m")
SEED = 1


def main(results: Path, system: str, labels: str, sound: str, *models: str) -> None:
    run = SystemRun(CorpusRun(results), system)
    trained = {name: run.model(name) for name in (labels, sound, *models)}
    with run.targets() as targets, ArrayCollection(shards(results / "audio")) as audio:
        for split in ("validation", "test"):
            found = _sources(run, split, targets, audio)
            for name, model in trained.items():
                print(f"{split}, {name}: {_figures(model, found)}", flush=True)
        found = _sources(run, "test", targets, audio)
        for name, model in trained.items():
            if "audio" in needs_of_model(model):
                for condition, change in CONDITIONS.items():
                    changed = [(_changed(source, change), true) for source, true in found]
                    print(f"test, {name}, {condition}: {_figures(model, changed)}", flush=True)
        aam = Aam.load(CodingRun(run.corpus, _coding(run)).model)
        _compare(run, aam, trained[labels], trained[sound], targets, audio)


def _coding(run: SystemRun) -> str:
    """Name of the visual coding whose appearance model the targets are of; the only one of a run."""
    return next(path.parent.name for path in sorted(run.corpus.folder.glob("codings/*/model.safetensors")))


def _sources(run: SystemRun, split: str, targets, audio) -> list[tuple[Source, np.ndarray]]:
    """What networks read of each utterance, and the true appearance (T, N)."""
    found = []
    for name in run.corpus.ids(split):
        true, sound = targets.array(name, "appearance"), Sound(audio.array(name, "samples"))
        source = Source(len(true), targets.rate(name), run.corpus.alignments[name], sound)
        found.append((source, true))
    return found


def centred(values: np.ndarray) -> np.ndarray:
    """A trajectory (T, N) less its mean over time."""
    return values - values.mean(axis=0)


def _agreement(pairs: Sequence[tuple[np.ndarray, np.ndarray]]) -> tuple[float, float]:
    """Mean over all frames of the root mean square difference and of the correlation of centred trajectories."""
    both = [(centred(one), centred(other)) for one, other in pairs]
    errors = np.concatenate([frame_rmse(one, other) for one, other in both])
    return float(errors.mean()), float(np.nan_to_num(np.concatenate([frame_correlation(*one) for one in both])).mean())


def _figures(model: Model, found: Sequence[tuple[Source, np.ndarray]]) -> str:
    error, corr = _agreement([(predict_source(model, source), true) for source, true in found])
    return f"RMSE(appearance) {error:.2f}, CORR {corr:.3f}"


def _changed(source: Source, change: Callable) -> Source:
    samples = change(source.sound.between(0, len(source.sound.samples)))
    return Source(source.frames, source.rate, source.alignment, Sound(to_int16(samples)))


def _band(low: float, high: float) -> Callable:
    """Butterworth band pass of the fourth order, as a telephone line has one."""
    from scipy.signal import butter, sosfiltfilt

    sections = butter(4, [low, high], "bandpass", fs=RATE, output="sos")
    return lambda samples: sosfiltfilt(sections, samples)


def _tilt(samples: np.ndarray) -> np.ndarray:
    """A dull room: a low pass of the first order at 1 kHz."""
    from scipy.signal import butter, sosfilt

    return sosfilt(butter(1, 1000, fs=RATE, output="sos"), samples)


def _noisy(decibels: float) -> Callable:
    """White noise, so many decibels below the sound."""

    def change(samples: np.ndarray) -> np.ndarray:
        size = np.sqrt(np.mean(samples**2)) * 10 ** (-decibels / 20)
        return samples + np.random.default_rng(SEED).normal(0, size, len(samples))

    return change


CONDITIONS: Mapping[str, Callable] = {
    "level -20 dB": lambda samples: samples / 10,
    "level -40 dB": lambda samples: samples / 100,
    "low pass of the first order, 1 kHz": _tilt,
    "telephone band, 300 to 3400 Hz": _band(300, 3400),
    "white noise, 20 dB below": _noisy(20),
    "white noise, 10 dB below": _noisy(10),
}


def _compare(run: SystemRun, aam: Aam, labels: Model, sound: Model, targets, audio) -> None:
    """Print how far the two networks agree on recordings and on the synthetic voice, and how often lips close."""
    recorded = _sources(run, "test", targets, audio)
    training = [(one.alignment, _opening(aam, true)) for one, true in _sources(run, "train", targets, audio)]
    closed = float(np.percentile([least for one in training for least in _least(*one, labels.rate)], 90))
    shares = state_shares(alignment for alignment, _ in training)
    spoken = [
        source
        for one in run.corpus.of_split("test")
        for source in _voiced(one.transcript, shares, phones_of(labels), labels.rate)
    ]
    print(f"lips count as closed below an opening of {closed:.2f} px; recorded: {_closures(aam, recorded, closed)}")
    for title, sources in (("recordings", [source for source, _ in recorded]), ("synthetic voice", spoken)):
        pairs = [(predict_source(labels, one), predict_source(sound, one)) for one in sources]
        error, corr = _agreement(pairs)
        openings = [[_opening(aam, part) for part in pair] for pair in pairs]
        lip = np.mean([np.corrcoef(*one)[0, 1] for one in openings])
        spread = np.mean([np.std(heard) / np.std(read) for read, heard in openings])
        print(
            f"{title}, sound against labels: RMSE(appearance) {error:.2f}, CORR {corr:.3f}, opening of the mouth: "
            f"correlation {lip:.2f}, ratio of deviations {spread:.2f}"
        )
        for name, number in (("labels", 0), ("sound", 1)):
            shown = [(source, pair[number]) for source, pair in zip(sources, pairs, strict=True)]
            print(f"{title}, {name}: {_closures(aam, shown, closed)}", flush=True)


def _voiced(text: str, shares: Mapping, phones: Sequence[str], rate: float) -> Iterator[Source]:
    """A sentence in the synthetic voice, with its phones and times."""
    for one in speak_text(text, shares=shares):
        alignment, _ = in_phones_of(one.alignment, phones)
        frames = max(1, int(len(one.samples) / one.rate * rate))
        yield Source(frames, rate, alignment, Sound.of(one.samples, one.rate))


def _opening(aam: Aam, appearance: np.ndarray) -> np.ndarray:
    """Distance of the inner lips' middles (T,) in pixels of the normalised face."""
    upper, lower = aam.points.mouth_middle
    points = aam.decode_points(np.asarray(appearance, np.float32))
    return np.linalg.norm(points[:, lower] - points[:, upper], axis=1)


def _least(alignment: Alignment, opening: np.ndarray, rate: float) -> list[float]:
    """Least opening in each p, b and m, with a frame on either side."""
    found = []
    for one in alignment.phones:
        if one.label in CLOSED:
            first, last = max(0, int(one.start * rate) - 1), int(np.ceil(one.end * rate)) + 1
            if len(opening[first:last]):
                found.append(float(opening[first:last].min()))
    return found


def _closures(aam: Aam, shown: Sequence[tuple[Source, np.ndarray]], closed: float) -> str:
    least = [
        one for source, appearance in shown for one in _least(source.alignment, _opening(aam, appearance), source.rate)
    ]
    return f"{np.mean(np.array(least) <= closed):.2f} of {len(least)} p, b and m closed" if least else "no p, b or m"


if __name__ == "__main__":
    run_main(main, __doc__)
