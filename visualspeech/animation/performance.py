"""The sound and the predicted appearance of a talking head, before any frame is rendered.

Each sentence is spoken and its appearance predicted. Both are spooled to disk, so that a text can have any length and
errors are found before the long rendering starts.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from visualspeech.animation.timings import Timings
from visualspeech.errors import DataError
from visualspeech.features.blocks.base import Source
from visualspeech.jobs import log
from visualspeech.media.spooling import Spool
from visualspeech.models.inventory import needs_of_model, phones_of, predict_source
from visualspeech.models.rest import REST, pause_weights
from visualspeech.models.task import Model
from visualspeech.speech.alignment import Alignment
from visualspeech.speech.sound import Sound
from visualspeech.speech.spoken import Spoken
from visualspeech.speech.substitutes import in_phones

MARGIN = 1.0  # seconds of a recording before and after a piece of it that a model which reads sound alone hears too
FULL_SCALE = 32768  # of 16 bit


@dataclass(frozen=True)
class Performance:
    """The sound and the predicted appearance of a text, before any frame is rendered.

    Parameters
    ----------
    text : of all sentences
    samples : (n,) int16, mono
    audio_rate : of the samples, in Hz
    appearance : (T, N) float32 at ``rate``
    rate : frame rate in Hz
    """

    text: str
    samples: Spool
    audio_rate: int
    appearance: Spool
    rate: float

    @property
    def seconds(self) -> float:
        """Duration of the appearance."""
        return len(self.appearance) / self.rate

    def sound(self) -> Iterator[np.ndarray]:
        """The samples as float32 in [-1, 1], in blocks of some seconds."""
        step = 4 * self.audio_rate
        for start in range(0, len(self.samples), step):
            yield self.samples[start : start + step].astype(np.float32) / FULL_SCALE


def perform(
    spoken: Iterable[Spoken], model: Model, rest: np.ndarray, ramp: float = REST, timings: Timings | None = None
) -> Performance:
    """Predict the appearance of all sentences, one after the other; memory does not grow with their number.

    Parameters
    ----------
    spoken : sentences in their order
    rest : (N,) appearance at rest
    ramp : seconds from the border of a pause until the face is fully at rest; at the border the appearance is that of
        the model, inside the pause that of the face at rest
    timings : to which the words and phones of every sentence are added

    Raises
    ------
    SettingError
        The phones of the model are of another phone set.
    DataError
        The sentences differ in their audio rate, or there are none.
    """
    texts: list[str] = []
    audio_rate = 0
    reported: set[str] = set()
    samples, faces = Spool(np.int16), Spool(np.float32, model.outputs)
    for one in spoken:
        if audio_rate and one.rate != audio_rate:
            raise DataError(
                f"one sentence has a sample rate of {one.rate} Hz, another of {audio_rate} Hz; give one rate."
            )
        audio_rate = one.rate
        alignment, replaced = in_phones(one.alignment, phones_of(model))
        if set(replaced) - reported:
            reported |= set(replaced)
            log.info(
                "some phones of the text did not occur in training: %s",
                ", ".join(f"{other} is shown for {phone}" for phone, other in sorted(replaced.items())),
            )
        # Sentences end at frame borders, so the last frame is filled with silence. An excess of one sample is rounding.
        count = max(1, int(np.ceil((len(one.samples) - 1) / one.rate * model.rate - 1e-6)))
        begin = len(faces) / model.rate
        faces.append(face_of(alignment, count, model, rest, ramp, _sound(one, model), one.begin))
        if timings is not None:
            timings.add(one.alignment, begin, len(faces) / model.rate)
        length = round(len(faces) * one.rate / model.rate) - len(samples)
        sound = np.pad(one.samples, (0, max(0, length - len(one.samples))))[:length]
        samples.append(np.clip(np.rint(sound * FULL_SCALE), -FULL_SCALE, FULL_SCALE - 1))
        texts.append(one.text)
    if not texts:
        raise DataError("there is nothing to say.")
    return Performance(" ".join(filter(None, texts)), samples, audio_rate, faces, float(model.rate))


def _sound(one: Spoken, model: Model) -> Sound | None:
    """The sound that a model reads of a sentence or piece; None for a model that reads none."""
    if "audio" not in needs_of_model(model):
        return None
    return one.sound or Sound.of(one.samples, one.rate)


def face_of(
    alignment: Alignment,
    frames: int,
    model: Model,
    rest: np.ndarray,
    ramp: float,
    sound: Sound | None = None,
    begin: float = 0.0,
) -> np.ndarray:
    """Appearance (frames, N) float32 of one sentence: predicted in speech, the face at rest in pauses.

    Parameters
    ----------
    rest, ramp : see :func:`perform`
    sound, begin : what the model hears, and the time in it of the first frame
    """
    weight = pause_weights(alignment, frames, model.rate, ramp)[:, None]
    before = after = 0
    if sound is not None and "text" not in needs_of_model(model):
        before = round(min(MARGIN, begin) * model.rate)
        left = sound.seconds - begin - frames / model.rate
        after = int(np.clip(left, 0, MARGIN) * model.rate)
    source = Source(before + frames + after, model.rate, alignment, sound, begin - before / model.rate)
    predicted = predict_source(model, source)[before : before + frames]
    return ((1 - weight) * predicted + weight * rest).astype(np.float32)
