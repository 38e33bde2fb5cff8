"""Making a study: utterances are drawn, conditions rendered and named at random, and the key is written apart."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np
import soundfile

from visualspeech.animation.label import labelled, title_bar
from visualspeech.animation.markers.rendering import chosen_clips
from visualspeech.animation.video import LABEL, even_sized
from visualspeech.corpora.findings import needed
from visualspeech.corpora.records import Utterance
from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.errors import CorpusError
from visualspeech.jobs import log, progress
from visualspeech.media.encoding import write_video
from visualspeech.media.loudness import at_loudness, common_loudness
from visualspeech.provenance import split_hash
from visualspeech.speech.tts import synthesise
from visualspeech.study.layouts import ATTENTION, ITEM, LEFT, NONE, PRACTICE, PREFERENCE, RIGHT
from visualspeech.study.records import (
    Condition,
    Item,
    Key,
    Question,
    SoundCheck,
    Stimulus,
    Study,
    write_key,
    write_study,
)
from visualspeech.study.settings import CONSENT, INTRODUCTION, StudySettings
from visualspeech.study.sources import Faces, Shown, check_length

WORDS = ("river", "window", "seven", "garden", "table", "yellow", "monday", "paper")
CHOICES = 4  # words of the sound check
GAP = 8  # pixels between the faces of a pair


@dataclass(frozen=True)
class Planned:
    """One item before it is rendered: its role, utterance, the conditions of each stimulus, and the asked answer."""

    role: str
    utterance: Utterance
    stimuli: tuple[tuple[Shown, ...], ...]
    expected: str | int = ""


@dataclass(frozen=True)
class Made:
    """A study whose stimuli lie in a folder, and what its key says beside the digest of the study."""

    study: Study
    stimuli: Mapping[str, Stimulus]
    expected: Mapping[str, Mapping[str, str | int]]


def make_study(
    media: Path,
    name: str,
    settings: StudySettings,
    conditions: Sequence[Shown],
    utterances: Sequence[Utterance],
    faces: Faces,
    names: Mapping[str, str],
    seed: int,
) -> Made:
    """Render the stimuli of a study into a folder.

    Parameters
    ----------
    media : an empty folder
    utterances : those that every condition has, of all splits
    names : ``corpus`` and ``consent``, for the metadata

    Raises
    ------
    CorpusError
        There is no test utterance, or a recording cannot be read.
    DataError
        The conditions of an utterance differ in length.
    """
    generator = np.random.default_rng([seed, *name.encode()])
    items = planned_items(settings, conditions, utterances, generator)
    used = {one.utterance.id: one.utterance for one in items}
    sounds = {}
    for one in used.values():
        with needed(one):
            samples, rate = faces.sound(one)
            frame_rate, count = faces.timing(one)
            sounds[one.id] = _of_length(samples, round(count / frame_rate * rate)), rate
    word = str(generator.choice(WORDS))
    spoken = synthesise(word) if settings.sound_check else None
    checked = (spoken.samples.astype(np.float32) / 32768, spoken.rate) if spoken else (np.zeros(1), 1)
    target = common_loudness([*sounds.values(), *([checked] if spoken else [])], settings.loudness)
    if target < settings.loudness - 0.05:
        log.info("the loudness is %.1f LUFS: above it, the loudest peaks would be clipped", target)
    sounds = {key: (at_loudness(samples, rate, target), rate) for key, (samples, rate) in sounds.items()}
    questions = asked(settings)
    writer = _Writer(media, settings, conditions, faces, sounds, names, generator)
    made, stimuli, expected = [], {}, {}
    for one in progress(items, len(items), "items"):
        item = writer.new_name()
        with needed(one.utterance):
            files, seconds = writer.write(one)
        for file, shown in zip(files, one.stimuli, strict=True):
            stimuli[file] = Stimulus(item, one.utterance.id, tuple(each.name for each in shown))
        made.append(Item(item, one.role, tuple(files), seconds))
        if one.role == ATTENTION:
            expected[item] = {question.name: one.expected for question in questions}
    sound = None
    if spoken:
        file = f"{writer.new_name()}.wav"
        soundfile.write(media / file, at_loudness(*checked, target), spoken.rate, subtype="PCM_16")
        others = generator.permutation([other for other in WORDS if other != word])[: CHOICES - 1]
        choices = generator.permutation([word, *others])
        sound = SoundCheck(file, tuple(map(str, choices)), word)
    made = [made[index] for index in generator.permutation(len(made))]
    texts = {
        "title": settings.title,
        "introduction": settings.introduction or INTRODUCTION,
        "consent": settings.consent or CONSENT,
    }
    study = Study(name, settings.kind, **texts, questions=questions, items=tuple(made), sound_check=sound)
    return Made(study, stimuli, expected)


def write_made(
    folder: Path,
    made: Made,
    conditions: Sequence[Mapping],
    split: Mapping[str, str],
    seed: int,
    corpus: str,
    published: str,
) -> None:
    """Write ``study.json`` and ``key.json`` of a study.

    Parameters
    ----------
    conditions : for each its ``name``, ``title``, ``system`` and ``model``
    split : of the corpus
    published : name of published figures, or empty
    """
    known = tuple(Condition(*(one[key] for key in ("name", "title", "system", "model"))) for one in conditions)
    written = write_study(folder, made.study)
    write_key(
        folder, Key(written.digest, corpus, split_hash(split), seed, published, known, made.stimuli, made.expected)
    )


def asked(settings: StudySettings) -> tuple[Question, ...]:
    """The questions of a study."""
    if settings.kind == PREFERENCE:
        choices = (LEFT, RIGHT) if settings.forced else (LEFT, NONE, RIGHT)
        return tuple(Question(name, text, choices) for name, text in settings.questions.items())
    scale = (settings.minimum, settings.maximum, settings.lowest, settings.highest)
    return tuple(Question(name, text, (), *scale) for name, text in settings.questions.items())


def planned_items(
    settings: StudySettings, conditions: Sequence[Shown], utterances: Sequence[Utterance], generator
) -> list[Planned]:
    """The items of a study: test utterances in random order, taken in turn from each speaker and emotion.

    Practice and attention items are of other utterances where the corpus has enough: of the validation split, or the
    test utterances that are left.

    Raises
    ------
    CorpusError
        There is no test utterance.
    """
    mixed = [utterances[index] for index in generator.permutation(len(utterances))]
    test = chosen_clips(of_split(mixed, "test"), len(mixed))
    if not test:
        raise CorpusError("no test utterance is in all conditions of the study; there is nothing to show.")
    shown, left = test[: settings.utterances], test[settings.utterances :]
    if len(shown) < settings.utterances:
        log.warning("the study has %d of the %d utterances: there are no more", len(shown), settings.utterances)
    others = [*of_split(mixed, "validation"), *left] or shown
    pair = settings.kind == PREFERENCE
    alone = [((one,),) for one in conditions]
    orders = [(tuple(conditions), tuple(conditions[::-1]))] if pair else alone
    items = [Planned(ITEM, utterance, stimuli) for utterance, stimuli in product(shown, orders)]
    if settings.practice:
        items.append(Planned(PRACTICE, others[0], orders[generator.integers(len(orders))]))
    for number in range(settings.attention):
        stimuli = orders[generator.integers(len(orders))][:1]
        if pair:
            answer = (LEFT, RIGHT)[(number + int(generator.integers(2))) % 2]
        else:
            # Far from the middle, where ratings gather.
            answer = int(generator.choice([settings.minimum, settings.minimum + 1]))
        items.append(Planned(ATTENTION, others[(number + 1) % len(others)], stimuli, answer))
    return items


def common_utterances(paths: Sequence[str | Path]) -> list[Utterance]:
    """The accepted utterances that every visual coding has, in the order of the first table."""
    first, *others = (read_utterances(path) for path in paths)
    ids = set.intersection(*({one.id for one in table} for table in (first, *others)))
    return [one for one in first if one.id in ids]


class _Writer:
    """Renders items into a folder under random names."""

    def __init__(self, media: Path, settings, conditions, faces: Faces, sounds, names, generator) -> None:
        self._media, self._faces, self._sounds, self._generator = media, faces, sounds, generator
        recorded = any(not one.model for one in conditions)
        # A label on some conditions would tell them apart, and one on recorded faces would be wrong.
        self._label = settings.label and not recorded
        permission = names["consent"].strip() or "No statement of consent was given for this corpus."
        self._metadata = {
            "title": "Stimulus of a viewing test",
            "comment": (
                "This video may be SYNTHETIC: it is a stimulus of a viewing test, and faces in it may have been made "
                f"by a computer model and never have moved like this. Whose face it is and by what permission: "
                f"{permission}"
            ),
            "synthetic": "perhaps" if recorded else "yes",
            "consent": permission,
        }  # fmt: skip

    def new_name(self) -> str:
        """A random name."""
        return self._generator.bytes(8).hex()

    def write(self, item: Planned) -> tuple[list[str], float]:
        """Write the stimuli of an item; returns the names of their files and their duration in seconds."""
        rate, count = self._faces.timing(item.utterance)
        files = []
        for shown in item.stimuli:
            files.append(f"{self.new_name()}.mp4")
            streams = [
                check_length(self._faces.frames(item.utterance, one), count, f"{item.utterance.id} ({one.name})")
                for one in shown
            ]
            frames = map(even_sized, _beside(streams, self._label))
            if item.role == ATTENTION:
                many = " to every question" if isinstance(item.expected, int) else ""
                frames = _instructed(frames, f"Attention check: answer {str(item.expected).upper()}{many}", count // 3)
            samples, sample_rate = self._sounds[item.utterance.id]
            write_video(self._media / files[-1], frames, rate, samples, sample_rate, dict(self._metadata))
        return files, count / rate


def _beside(streams: Sequence[Iterator[np.ndarray]], label: bool) -> Iterator[np.ndarray]:
    """Frames of all streams side by side with a gap."""
    for frames in zip(*streams, strict=True):
        marked = [labelled(frame, LABEL) if label else frame for frame in frames]
        gap = np.zeros((len(marked[0]), GAP, 3), np.uint8)
        yield np.hstack([part for frame in marked for part in (frame, gap)][:-1])


def _instructed(frames: Iterator[np.ndarray], text: str, begin: int) -> Iterator[np.ndarray]:
    """Frames with a bar of text across their middle, from frame ``begin`` on."""
    bar = None
    for number, frame in enumerate(frames):
        if number >= begin:
            if bar is None:
                margin = frame.shape[1] // 12
                bar = title_bar(["", text, ""], [margin, frame.shape[1] - 2 * margin, margin], max(24, len(frame) // 6))
            frame = frame.copy()
            top = (len(frame) - len(bar)) // 2
            frame[top : top + len(bar)] = bar
        yield frame


def _of_length(samples: np.ndarray, length: int) -> np.ndarray:
    """Sound cut or filled with silence to the length of the frames."""
    return np.pad(samples[:length], (0, max(0, length - len(samples))))
