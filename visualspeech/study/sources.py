"""The faces of a study: frames of an utterance in one condition, as talking head or as points and lines."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from visualspeech.animation.markers.clips import Motion, drawn, video_rate
from visualspeech.animation.markers.drawing import TRUE
from visualspeech.animation.markers.rendering import motion_of
from visualspeech.animation.video import AUDIO_RATE, Recording, Speaker, synthetic_frames
from visualspeech.animation.video_settings import VideoSettings
from visualspeech.corpora.records import Utterance
from visualspeech.errors import DataError
from visualspeech.face.marker_coding import MarkerCoding
from visualspeech.features.resampling import resample
from visualspeech.media.reading import probe, read_audio, read_frames
from visualspeech.storage.arrays import ArrayCollection, ArrayReader


@dataclass(frozen=True)
class Shown:
    """What a condition of a study is.

    Parameters
    ----------
    name : of the condition
    coding : visual coding of its model; empty for the recorded face
    model : row of the predictions; empty for the recorded face
    """

    name: str
    coding: str
    model: str


class Faces(Protocol):
    """Frames and sound of the utterances of a study; all conditions of an utterance have the same frames and rate."""

    def timing(self, utterance: Utterance) -> tuple[float, int]:
        """Frame rate in Hz and number of frames of an utterance's stimuli."""

    def frames(self, utterance: Utterance, condition: Shown) -> Iterator[np.ndarray]:
        """Its frames in a condition, (height, width, 3) uint8 RGB."""

    def sound(self, utterance: Utterance) -> tuple[np.ndarray, int]:
        """Its recorded sound (n,) in [-1, 1] and the sample rate in Hz."""


@dataclass(frozen=True)
class Pictured:
    """Talking heads: frames of the recording whose lower face a model predicts.

    Parameters
    ----------
    landmarks, pose : of the recordings
    textures, speakers : of each visual coding, by its name
    predictions : of each condition with a model, by its name
    """

    landmarks: ArrayCollection
    pose: ArrayCollection
    textures: Mapping[str, ArrayCollection]
    speakers: Mapping[str, Speaker]
    predictions: Mapping[str, ArrayReader]

    def timing(self, utterance: Utterance) -> tuple[float, int]:
        return probe(utterance.media).rate, len(self.landmarks.array(utterance.id, "points"))

    def frames(self, utterance: Utterance, condition: Shown) -> Iterator[np.ndarray]:
        recorded = read_frames(utterance.media, utterance.start, utterance.end)
        if not condition.model:
            return recorded
        rate, length = self.timing(utterance)
        recording = Recording.read(self.landmarks, self.pose, self.textures[condition.coding], utterance.id)
        predicted = self.predictions[condition.name]
        values = resample(predicted.array(utterance.id, "appearance"), predicted.rate(utterance.id), rate, length)
        speaker = self.speakers[condition.coding]
        return synthetic_frames(recorded, values, recording, speaker, VideoSettings().rendering, rate=rate)

    def sound(self, utterance: Utterance) -> tuple[np.ndarray, int]:
        return read_audio(utterance.media, AUDIO_RATE, utterance.start, utterance.end), AUDIO_RATE


@dataclass(frozen=True)
class Drawn:
    """Points and lines of a face; all conditions are drawn alike.

    Parameters
    ----------
    codings, parameters : of each visual coding, by its name
    predictions : of each condition with a model, by its name
    audio : ``samples`` of the utterances
    """

    codings: Mapping[str, MarkerCoding]
    parameters: Mapping[str, ArrayCollection]
    predictions: Mapping[str, ArrayReader]
    audio: ArrayCollection

    def timing(self, utterance: Utterance) -> tuple[float, int]:
        recorded = self._recorded(next(iter(self.codings)), utterance)
        rate = video_rate(recorded.rate)
        return rate, max(1, round(len(recorded.points) / recorded.rate * rate))

    def frames(self, utterance: Utterance, condition: Shown) -> Iterator[np.ndarray]:
        rate, count = self.timing(utterance)
        name = condition.coding or next(iter(self.codings))
        coding, recorded = self.codings[name], self._recorded(name, utterance)
        motion = motion_of(coding, self.predictions[condition.name], utterance) if condition.model else recorded
        # The view follows from the recording alone, so that it tells nothing of the condition.
        return drawn(motion.at(rate, count), (recorded.at(rate, count),), coding.markers.names, TRUE)

    def sound(self, utterance: Utterance) -> tuple[np.ndarray, int]:
        samples = self.audio.array(utterance.id, "samples").astype(np.float32) / 32768
        return samples, round(self.audio.rate(utterance.id))

    def _recorded(self, coding: str, utterance: Utterance) -> Motion:
        return motion_of(self.codings[coding], self.parameters[coding], utterance)


def check_length(frames: Iterator[np.ndarray], count: int, what: str) -> Iterator[np.ndarray]:
    """Yield the same frames; raises :class:`DataError` where there are fewer or more than ``count``."""
    number = 0
    for frame in frames:
        number += 1
        yield frame
    if number != count:
        raise DataError(f"{what} has {number} frames in place of {count}, and its stimuli would differ in length.")


@contextmanager
def opened_faces(source, codings: Sequence[str], conditions: Sequence[str]) -> Iterator[Faces]:
    """The faces of a study, in the files of its rule.

    Parameters
    ----------
    source : the rule's inputs: lists of files; those of another kind of visual coding are empty
    codings : names of the visual codings, in the order of their files
    conditions : names of the conditions with a model, in the order of ``source.predictions``
    """
    with ExitStack() as stack:
        predictions = {
            name: stack.enter_context(ArrayReader(path))
            for name, path in zip(conditions, source.predictions, strict=True)
        }

        def by_coding(paths) -> dict[str, ArrayCollection]:
            return {
                name: stack.enter_context(ArrayCollection(own)) for name, own in _grouped(list(paths), codings).items()
            }

        if source.aam:
            speakers = {
                name: Speaker.load(source.head, aam, reference)
                for name, aam, reference in zip(codings, source.aam, source.reference, strict=True)
            }
            landmarks, pose = (stack.enter_context(ArrayCollection(one)) for one in (source.landmarks, source.pose))
            yield Pictured(landmarks, pose, by_coding(source.textures), speakers, predictions)
        else:
            loaded = {name: MarkerCoding.load(path) for name, path in zip(codings, source.markers, strict=True)}
            audio = stack.enter_context(ArrayCollection(source.audio))
            yield Drawn(loaded, by_coding(source.parameters), predictions, audio)


def _grouped(paths: Sequence[str], names: Sequence[str]) -> dict[str, Sequence[str]]:
    """Files of several codings, listed one coding after the other, by the name of the coding."""
    each = len(paths) // len(names)
    return {name: paths[index * each : (index + 1) * each] for index, name in enumerate(names)}
