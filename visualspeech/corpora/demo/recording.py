"""Recordings of the demo speakers: video with sound, a transcript beside it, and the ground truth in one file."""

import zlib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from visualspeech.corpora.demo.articulation import PARAMETERS
from visualspeech.corpora.demo.characters import CHARACTERS, EMOTIONS, MOVEMENTS, Character, Emotion
from visualspeech.corpora.records import Utterance
from visualspeech.fields import MAX_SEED, Settings, setting
from visualspeech.jobs import progress
from visualspeech.speech.phones import SILENCE
from visualspeech.storage.arrays import ArrayReader, ArrayWriter
from visualspeech.storage.files import write_text
from visualspeech.timing import frame_times, frames_in

CONSENT = (
    "The face is nobody's: made by rule from a public-domain photograph and no longer that person's; "
    "the voice is synthetic. Free to use."
)

_FAST = "veryfast"  # preset of x264: half of the time of a recording is its encoding


@dataclass(frozen=True)
class DemoSettings(Settings):
    """Recordings of the demo corpus."""

    section = "demo"
    seed: int = setting(1, "Seed of head movement, blinks, light and noise.", minimum=0, maximum=MAX_SEED)
    rate: float = setting(25.0, "Frame rate of the video in Hz.", minimum=5, maximum=120)
    rate_wpm: int = setting(160, "Speaking rate in words per minute.", minimum=80, maximum=450)
    pitch: int = setting(45, "Pitch of the voice, from 0 (low) to 100 (high).", minimum=0, maximum=100)
    silence: float = setting(
        0.2, "Silence before and after the speech, filled with quiet noise, in seconds.", minimum=0, maximum=5
    )
    noise: float = setting(5.0, "Standard deviation of the background noise, in 16-bit steps.", minimum=0, maximum=1000)
    articulation: float = setting(1.0, "Opening of the mouth, as a multiple of normal speech.", minimum=0, maximum=1.5)


@dataclass(frozen=True)
class Truth:
    """The ground truth of a recording.

    Parameters
    ----------
    parameters : (T, 6) mouth parameters, in the order of ``articulation.PARAMETERS``
    points : (T, 68, 2) points in the frame, in pixels, iBUG order
    frontal : (T, 68, 2) the same points of the head without pose, in canonical pixels
    rotation : (T, 3) Rodrigues vectors in radians
    translation : (T, 3) in canonical pixels
    closed_eyes : (T,) 0 open to 1 closed
    phones, words : (label, start, end) in seconds; phones cover the recording without gaps
    duration : of the recording in seconds
    expression : (T, M) amounts of the movements of an emotion, in the order of ``characters.MOVEMENTS``; None in a
        corpus without emotions
    """

    parameters: np.ndarray
    points: np.ndarray
    frontal: np.ndarray
    rotation: np.ndarray
    translation: np.ndarray
    closed_eyes: np.ndarray
    phones: tuple[tuple[str, float, float], ...]
    words: tuple[tuple[str, float, float], ...]
    duration: float
    expression: np.ndarray | None = None


def record_shard(
    utterances: Iterable[Utterance],
    folder: str | Path,
    truth_path: str | Path,
    settings: DemoSettings | None = None,
) -> None:
    """Record utterances: ``folder/id.mp4`` and ``folder/id.txt`` for each, and one file with the ground truth of all.

    Raises
    ------
    StorageError
        A file cannot be written.
    """
    from visualspeech.corpora.demo.listing import media_path

    utterances = list(utterances)
    settings = settings or DemoSettings()
    Path(folder).mkdir(parents=True, exist_ok=True)
    renderers = {}
    with ArrayWriter(truth_path, kind="truth of the demo corpus", width=320, height=360) as out:
        for utterance in progress(utterances, len(utterances), "recordings"):
            if utterance.speaker not in renderers:
                from visualspeech.corpora.demo.rendering import Renderer

                renderers[utterance.speaker] = Renderer(character_of(utterance))
            renderer = renderers[utterance.speaker]
            truth = record(utterance, media_path(folder, utterance.id), settings, renderer)
            add_truth(out, utterance.id, truth, settings.rate)


def record(utterance: Utterance, path: str | Path, settings: DemoSettings | None = None, renderer=None) -> Truth:
    """Write the recording of one utterance (MP4) and its transcript (``.txt``); returns the ground truth.

    Parameters
    ----------
    renderer : a :class:`visualspeech.corpora.demo.rendering.Renderer` of the speaker to reuse; default: a new one
    """
    from visualspeech.corpora.demo import articulation, motion
    from visualspeech.corpora.demo.expression import course
    from visualspeech.corpora.demo.rendering import Renderer, image_points
    from visualspeech.media.encoding import write_video
    from visualspeech.speech.tts import synthesise

    settings = settings or DemoSettings()
    character, emotion = character_of(utterance), EMOTIONS.get(utterance.emotion, Emotion())
    renderer = renderer or Renderer(character)
    seeds = [settings.seed, zlib.crc32(utterance.id.encode())]
    random = np.random.default_rng(seeds)
    pitch = int(np.clip(settings.pitch + character.pitch + emotion.pitch, 0, 100))
    rate_wpm = int(np.clip(round(settings.rate_wpm * character.rate * emotion.rate), 80, 450))
    speech = synthesise(utterance.transcript, character.voice, rate_wpm, pitch)
    samples, phones, words = _padded(speech, settings, random, emotion.level)
    duration = len(samples) / speech.rate
    times = frame_times(frames_in(duration, settings.rate), settings.rate)
    parameters = articulation.movement(phones, times, settings.articulation * emotion.articulation)
    moves = motion.draw(times, random)
    expression, amounts = None, [{}] * len(times)
    if utterance.emotion:
        expression = course(emotion, words, phones, times, np.random.default_rng([*seeds, 1]))
        amounts = [dict(zip(MOVEMENTS, map(float, row), strict=True)) for row in expression]
    points = [image_points(parameters[t], moves, t, character, amounts[t]) for t in range(len(times))]
    write_video(
        path,
        (renderer.frame(parameters[t], moves, t, amounts[t]) for t in range(len(times))),
        settings.rate,
        samples.astype(np.float32) / 32768,
        speech.rate,
        {"comment": f"Synthetic speaker of the demo corpus. {CONSENT}", "title": utterance.id},
        preset=_FAST if utterance.emotion else "medium",
    )
    write_text(Path(path).with_suffix(".txt"), utterance.transcript + "\n")
    return Truth(
        parameters=parameters,
        points=np.array([image for _, image in points]),
        frontal=np.array([frontal for frontal, _ in points]),
        rotation=moves.rotation,
        translation=moves.translation,
        closed_eyes=moves.closed_eyes,
        phones=phones,
        words=words,
        duration=duration,
        expression=expression,
    )


def character_of(utterance: Utterance) -> Character:
    """The speaker of an utterance; one that is no demo speaker has the face and voice of the first."""
    return CHARACTERS.get(utterance.speaker, CHARACTERS["demo"])


def _padded(
    speech, settings: DemoSettings, random: np.random.Generator, level: float = 1.0
) -> tuple[np.ndarray, tuple, tuple]:
    """Samples, phones and words of the speech with silence before and after it and quiet noise throughout.

    The duration is a whole number of frames; the times of phones and words count from the first sample.
    """
    lead = int(round(settings.silence * speech.rate))
    frames = int(np.ceil((len(speech.samples) + 2 * lead) / speech.rate * settings.rate))
    total = int(round(frames / settings.rate * speech.rate))
    sound = random.normal(0.0, settings.noise, total)
    sound[lead : lead + len(speech.samples)] += 0.7 * level * speech.samples
    offset, duration = lead / speech.rate, total / speech.rate
    inner = [(phone, start + offset, end + offset) for phone, start, end in speech.phones]
    phones = [(SILENCE, 0.0, inner[0][1]), *inner, (SILENCE, inner[-1][2], duration)]
    joined: list[tuple[str, float, float]] = []
    for phone, start, end in phones:
        if joined and phone == SILENCE == joined[-1][0]:
            joined[-1] = (SILENCE, joined[-1][1], end)
        elif end > start:
            joined.append((phone, start, end))
    words = tuple((word, start + offset, end + offset) for word, start, end in speech.words)
    return np.clip(np.round(sound), -32768, 32767).astype(np.int16), tuple(joined), words


def add_truth(out: ArrayWriter, utterance_id: str, truth: Truth, rate: float) -> None:
    """Write the ground truth of one utterance; labels of phones and words become attributes, separated by spaces."""
    arrays = {
        "parameters": truth.parameters,
        "points": truth.points.astype(np.float32),
        "frontal": truth.frontal.astype(np.float32),
        "rotation": truth.rotation,
        "translation": truth.translation,
        "closed_eyes": truth.closed_eyes,
        "phone_times": np.array([times for _, *times in truth.phones]),
        "word_times": np.array([times for _, *times in truth.words]).reshape(-1, 2),
    }
    expressed = {}
    if truth.expression is not None:
        arrays["expression"] = truth.expression
        expressed["expression_names"] = " ".join(MOVEMENTS)
    units = {"points": "px", "frontal": "px", "rotation": "rad", "translation": "px", "phone_times": "s"}
    units |= {"word_times": "s"}
    out.add(
        utterance_id,
        arrays,
        rate,
        units,
        phones=" ".join(phone for phone, *_ in truth.phones),
        words=" ".join(word for word, *_ in truth.words),
        parameter_names=" ".join(PARAMETERS),
        duration=truth.duration,
        **expressed,
    )


def read_truth(reader: ArrayReader, utterance_id: str) -> Truth:
    """The ground truth that :func:`add_truth` wrote."""
    arrays, attributes = reader[utterance_id], reader.attributes(utterance_id)
    tiers = [
        tuple(
            (label, float(start), float(end))
            for label, (start, end) in zip(attributes[name].split(), arrays[times], strict=True)
        )
        for name, times in (("phones", "phone_times"), ("words", "word_times"))
    ]
    names = ("parameters", "points", "frontal", "rotation", "translation", "closed_eyes")
    return Truth(*(arrays[name] for name in names), *tiers, float(attributes["duration"]), arrays.get("expression"))
