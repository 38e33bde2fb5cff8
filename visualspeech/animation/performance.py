"""What a talking head says and how its face moves, before any picture is made.

Sentence after sentence is spoken and goes through the model; sound and appearance are kept on disk, so that a text
may be of any length, and what can be wrong with it is found before the long work of the pictures.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from visualspeech.errors import DataError
from visualspeech.jobs import log
from visualspeech.media.spooling import Spool
from visualspeech.models.inventory import phones_of, predict_alignment
from visualspeech.models.task import Model
from visualspeech.speech.alignment import Alignment
from visualspeech.speech.phones import SILENCE
from visualspeech.speech.spoken import Spoken
from visualspeech.speech.substitutes import substitutes
from visualspeech.timing import frame_times

FULL_SCALE = 32768  # of 16 bit
REST = 0.12  # seconds from the border of a pause until the face is wholly at rest: speaker s1 of GRID takes as long


@dataclass(frozen=True)
class Performance:
    """What is said and how the face moves, before any picture is made.

    Parameters
    ----------
    text : all of it
    samples : (n,) int16, mono
    audio_rate : samples a second
    appearance : (T, N) float32 at ``rate``
    rate : frames a second
    """

    text: str
    samples: Spool
    audio_rate: int
    appearance: Spool
    rate: float

    @property
    def seconds(self) -> float:
        """Length of the pictures."""
        return len(self.appearance) / self.rate

    def sound(self) -> Iterator[np.ndarray]:
        """The samples as float32 in [-1, 1], some seconds at a time."""
        step = 4 * self.audio_rate
        for start in range(0, len(self.samples), step):
            yield self.samples[start : start + step].astype(np.float32) / FULL_SCALE


def perform(spoken: Iterable[Spoken], model: Model, rest: np.ndarray, ramp: float = REST) -> Performance:
    """Predict the face of everything that is said, sentence by sentence; memory does not grow with their number.

    Parameters
    ----------
    spoken : sentences in their order
    rest : (N,) appearance in silence
    ramp : seconds from the border of a pause until the face is wholly at rest; speech goes into a pause and comes out
        of it by the model alone, and inside it the mouth is that of the speaker in silence

    Raises
    ------
    SettingError
        The model knows none of the phones.
    DataError
        The sentences differ in their sound's rate, or there are none.
    """
    texts: list[str] = []
    audio_rate = 0
    told: set[str] = set()
    samples, faces = Spool(np.int16), Spool(np.float32, model.outputs)
    for one in spoken:
        if audio_rate and one.rate != audio_rate:
            raise DataError(f"one sentence is sound of {one.rate} Hz, another of {audio_rate} Hz.")
        audio_rate = one.rate
        alignment, replaced = in_phones_of(one.alignment, phones_of(model))
        if set(replaced) - told:
            told |= set(replaced)
            log.info(
                "the model has not learnt some phones of this text: %s",
                ", ".join(f"{other} is shown for {phone}" for phone, other in sorted(replaced.items())),
            )
        # Every sentence ends with a frame: what is missing of its last is silence. One sample over is rounding.
        count = max(1, int(np.ceil((len(one.samples) - 1) / one.rate * model.rate - 1e-6)))
        faces.append(face_of(alignment, count, model, rest, ramp))
        length = round(len(faces) * one.rate / model.rate) - len(samples)
        sound = np.pad(one.samples, (0, max(0, length - len(one.samples))))[:length]
        samples.append(np.clip(np.rint(sound * FULL_SCALE), -FULL_SCALE, FULL_SCALE - 1))
        texts.append(one.text)
    if not texts:
        raise DataError("there is nothing to say.")
    return Performance(" ".join(filter(None, texts)), samples, audio_rate, faces, float(model.rate))


def in_phones_of(alignment: Alignment, phones) -> tuple[Alignment, dict[str, str]]:
    """An alignment in the phones that a model knows, and which phones were replaced by which.

    Raises
    ------
    SettingError
        The model's phones are of another kind.
    """
    replaced = substitutes((one.label for one in alignment.phones), phones) if phones else {}
    if not replaced:
        return alignment, {}
    renamed = tuple(replace(one, label=replaced.get(one.label, one.label)) for one in alignment.phones)
    return replace(alignment, phones=renamed), replaced


def face_of(alignment: Alignment, frames: int, model: Model, rest: np.ndarray, ramp: float) -> np.ndarray:
    """Appearance (frames, N) of one sentence: the model's, and in pauses the face at rest.

    Parameters
    ----------
    ramp : seconds from the border of a pause to the face at rest
    """
    weight = pause_weights(alignment, frames, model.rate, ramp)[:, None]
    return ((1 - weight) * predict_alignment(model, alignment, frames) + weight * rest).astype(np.float32)


def pause_weights(alignment: Alignment, frames: int, rate: float, ramp: float) -> np.ndarray:
    """How much each frame is at rest, (frames,) from 0 in speech to 1 deeper than ``ramp`` seconds inside a pause.

    Before the beginning and after the end there is silence, so a pause there reaches on without end.
    """
    times = frame_times(frames, rate)
    depth = np.zeros(frames)
    last = alignment.phones[-1].end
    for one in alignment.phones:
        if one.label == SILENCE:
            since = np.inf if one.start <= 0 else times - one.start
            until = np.inf if one.end >= last else one.end - times
            inside = (times >= one.start) & ((times < one.end) | (one.end >= last))
            depth = np.where(inside, np.minimum(since, until) * np.ones(frames), depth)
    # Beyond the alignment's end nobody speaks.
    share = np.clip(depth / ramp, 0, 1)
    return share * share * (3 - 2 * share)
