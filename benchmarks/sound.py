"""Networks driven by sound: against those driven by labels, on other levels and channels, and on another voice.

Run: python -m benchmarks.sound RESULTS SYSTEM LABELS SOUND [MODELS ...]

RESULTS is the folder of a corpus (results/grid), SYSTEM a system that was run on it, LABELS a network that reads labels
(FBB-128), SOUND one that reads sound alone (FBB-128-mel); MODELS are further networks (FBB-128-tri-mel). Errors are of
centred trajectories: prediction and truth of each utterance less their own means over it. Prints

1. RMSE(appearance) and CORR (Eq. 18 and 19) of each network on the validation and the test utterances;
2. for the networks that read sound: the same of the test utterances at other levels, through filters, and in noise;
3. for the test utterances and for the synthetic voice reading their sentences: how far the trajectories of SOUND, and
   those of LABELS on recognised phones, are from those of LABELS, which reads the true phones and times; how well the
   openings of the lips agree, for the recordings also with the tracked ones; and the share
   of p, b and m, of f and v in which the lips close, and of open vowels in which they open, as measured by the recorded
   speaker (:mod:`visualspeech.evaluation.articulation`);
4. for the test utterances: how well pauses by the level (:mod:`visualspeech.speech.segmentation`) agree with those of
   the forced alignment.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.articulation import coding_of
from benchmarks.command import run_main
from benchmarks.runs import CorpusRun, SystemRun, shards
from visualspeech.evaluation.articulation import TARGETS, Target, openings_of, targets_of
from visualspeech.evaluation.scoring import frame_correlation, frame_rmse
from visualspeech.face.lips import lip_opening
from visualspeech.face.point_sets import to_points
from visualspeech.features.blocks.base import Source
from visualspeech.models.inventory import needs_of_model, phones_of, predict_source
from visualspeech.models.task import Model
from visualspeech.speech.alignment import silent_frames
from visualspeech.speech.pieces import recognised_pieces
from visualspeech.speech.segmentation import segmented
from visualspeech.speech.sound import RATE, Sound, to_int16
from visualspeech.speech.spoken import speak_text, state_shares, timed
from visualspeech.speech.substitutes import in_phones
from visualspeech.storage.arrays import ArrayCollection

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
        _compare(run, coding_of(run, labels), trained[labels], trained[sound], targets, audio)
        print(_pauses([source for source, _ in found]))


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


def _compare(run: SystemRun, coding, labels: Model, sound: Model, targets, audio) -> None:
    """Print how far the two networks agree on recordings and on the synthetic voice, and how often lips close."""
    recorded = _sources(run, "test", targets, audio)
    training = [
        (_tracked(coding, targets, name), run.corpus.alignments[name], targets.rate(name))
        for name in run.corpus.ids("train")
    ]
    lips = targets_of(training)
    shares, phones = state_shares(alignment for _, alignment, _ in training), phones_of(labels)
    texts = [one.transcript for one in run.corpus.of_split("test")]
    spoken = [source for text in texts for source in _voiced(text, shares, phones, labels.rate)]
    tracked = [_tracked(coding, targets, name) for name in run.corpus.ids("test")]
    heard = [source for source, _ in recorded]
    print(f"recordings, tracked: {_closed(heard, tracked, lips)}")
    for title, sources, wanted in (("recordings", heard, tracked), ("synthetic voice", spoken, None)):
        read = [predict_source(labels, one) for one in sources]
        ways = {
            "labels": read,
            "sound": [predict_source(sound, one) for one in sources],
            "recognised phones": [predict_source(labels, _recognised(one, shares, phones)) for one in sources],
        }
        openings = {
            name: [lip_opening(coding.decode_points(one), coding.points) for one in shown]
            for name, shown in ways.items()
        }
        for name, shown in ways.items():
            error, corr = _agreement(list(zip(shown, read, strict=True)))
            against = {"labels": openings["labels"], **({"tracked": wanted} if wanted else {})}
            alike = ", ".join(f"with {other} {_alike(openings[name], true):.2f}" for other, true in against.items())
            print(
                f"{title}, {name}: against labels RMSE(appearance) {error:.2f}, CORR {corr:.3f}; correlation of the "
                f"opening {alike}; {_closed(sources, openings[name], lips)}",
                flush=True,
            )


def _alike(openings: Sequence[np.ndarray], others: Sequence[np.ndarray]) -> float:
    """Mean correlation over utterances of openings of the lips."""
    return float(np.mean([np.corrcoef(one, other)[0, 1] for one, other in zip(openings, others, strict=True)]))


def _recognised(source: Source, shares: Mapping, phones: Sequence[str]) -> Source:
    """The same with phones that are recognised in its sound."""
    *_, (_, found) = recognised_pieces([source.sound.samples], source.rate)
    return replace(source, alignment=in_phones(timed(found, (), shares), phones)[0])


def _pauses(sources: Sequence[Source]) -> str:
    """Agreement of pauses by the level with those of the alignment, at 100 Hz."""
    both = []
    for one in sources:
        samples = one.sound.samples
        frames = len(samples) * 100 // RATE
        both.append([silent_frames(found, frames, 100.0) for found in (segmented(samples), one.alignment)])
    level, aligned = (np.concatenate(part) for part in zip(*both, strict=True))
    return (
        f"pauses by level: {np.mean(level == aligned):.3f} of the frames as in the alignment, "
        f"{np.mean(level[~aligned]):.3f} of the speech called a pause, {np.mean(~level[aligned]):.3f} of the pauses "
        "called speech"
    )


def _tracked(coding, targets, name: str) -> np.ndarray:
    """Opening of the lips (T,) of the recorded points of an utterance."""
    return lip_opening(to_points(targets.array(name, "points")), coding.points)


def _voiced(text: str, shares: Mapping, phones: Sequence[str], rate: float) -> Iterator[Source]:
    """A sentence in the synthetic voice, with its phones and times."""
    for one in speak_text(text, shares=shares):
        alignment, _ = in_phones(one.alignment, phones)
        frames = max(1, int(len(one.samples) / one.rate * rate))
        yield Source(frames, rate, alignment, Sound.of(one.samples, one.rate))


def _closed(sources: Sequence[Source], openings: Sequence[np.ndarray], lips: Sequence[Target]) -> str:
    """Share of the occurrences of each class of phones in which the lips close, or open."""
    found = []
    for one in lips:
        pairs = zip(sources, openings, strict=True)
        reached = [
            one.reached(openings_of(opening, source.alignment, source.rate, one.name)) for source, opening in pairs
        ]
        every = np.concatenate(reached)
        found.append(f"{TARGETS[one.name]} {every.mean():.2f} ({len(every)})")
    return "lips reach their target: " + ", ".join(found)


if __name__ == "__main__":
    run_main(main, __doc__)
