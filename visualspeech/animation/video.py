"""Videos of the talking head: original, reconstruction and prediction side by side, with sound and metadata.

A rendered face looks like a person saying something in a way that was never recorded. The metadata of every file
therefore state that it is synthetic, by which model, from which corpus and by whose permission. Each synthetic frame
carries a small label unless that is switched off.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import tee
from pathlib import Path
from typing import NamedTuple

import numpy as np

from visualspeech.animation.label import labelled, title_bar, title_height
from visualspeech.animation.rendering import RenderSettings, place, talking_head
from visualspeech.animation.video_settings import VideoSettings
from visualspeech.corpora.records import Utterance
from visualspeech.errors import DataError
from visualspeech.face.aam.model import Aam
from visualspeech.face.aam.reference import Reference
from visualspeech.face.drift import FaceReference, reference_face
from visualspeech.face.head import HeadModel
from visualspeech.face.point_sets import to_vector
from visualspeech.face.pose import Pose
from visualspeech.features.resampling import resample
from visualspeech.media.encoding import write_video
from visualspeech.media.reading import probe, read_audio, read_frames

AUDIO_RATE = 48000
LABEL = "synthetic"


class Panel(NamedTuple):
    """One column of a video: its title, its frames (height, width, 3) uint8 RGB, and whether they are synthetic."""

    title: str
    frames: Iterable[np.ndarray]
    synthetic: bool = True


@dataclass(frozen=True)
class Speaker:
    """The models of one speaker for rendering: 3-D head, appearance model and texture grid."""

    head: HeadModel
    aam: Aam
    reference: Reference

    @classmethod
    def load(cls, head: str | Path, aam: str | Path, reference: str | Path) -> "Speaker":
        """The speaker in three model files.

        Raises
        ------
        StorageError
            One of them is missing or of another kind.
        """
        return cls(HeadModel.load(head), Aam.load(aam), Reference.load(reference))


@dataclass(frozen=True)
class Recording:
    """Measurements of one recorded utterance.

    Parameters
    ----------
    landmarks : (T, 68, 2) in pixels of the recording
    pose : of the T frames
    drift : the utterance's reference face
    """

    landmarks: np.ndarray
    pose: Pose
    drift: FaceReference

    @classmethod
    def read(cls, landmarks, pose, textures, utterance_id: str) -> "Recording":
        """One utterance from opened files of landmarks, pose and textures."""
        points = landmarks.array(utterance_id, "points")
        return cls(points, Pose.read(pose, utterance_id), reference_face(textures, utterance_id))


def synthetic_frames(
    frames: Iterable[np.ndarray],
    appearance: np.ndarray,
    recording: Recording,
    speaker: Speaker,
    settings: RenderSettings | None = None,
    *,
    rate: float,
) -> Iterator[np.ndarray]:
    """Recorded frames whose lower face is decoded from appearance parameters, one frame at a time.

    Parameters
    ----------
    frames : the T frames of the recording
    appearance : (T, N) v at the recording's frame rate
    rate : that frame rate in Hz

    Raises
    ------
    DataError
        The lengths differ.
    """
    appearance = np.asarray(appearance, np.float32)
    shape = to_vector(speaker.aam.decode_points(appearance)) + (recording.drift.shape - speaker.aam.drift.shape)
    points = speaker.reference.points
    placement = place(recording.landmarks, shape, recording.pose, speaker.head, points, settings, rate=rate)
    textures = _textures(appearance, recording, speaker.aam)
    return talking_head(frames, placement, textures, speaker.reference, settings, rate=rate)


def _textures(appearance: np.ndarray, recording: Recording, aam: Aam) -> Iterator[np.ndarray]:
    """Textures with the light of the recording, decoded a few at a time because each takes 72 kB."""
    light = recording.drift.texture - aam.drift.texture
    for start in range(0, len(appearance), 25):
        yield from aam.decode_texture(appearance[start : start + 25]) + light


def side_by_side(panels: Sequence[Panel], label: bool = True) -> Iterator[np.ndarray]:
    """Yield the frames of all panels side by side under a title bar, with even width and height.

    Raises
    ------
    DataError
        The panels differ in length or in the height of their frames.
    """
    streams = [iter(panel.frames) for panel in panels]
    bar = None
    for index in range(2**62):
        frames = [next(stream, None) for stream in streams]
        if all(frame is None for frame in frames):
            return
        for panel, frame in zip(panels, frames, strict=True):
            if frame is None:
                raise DataError(f"the panel {panel.title!r} ends after {index} frames, other panels are longer.")
            if frame.shape[0] != frames[0].shape[0]:
                raise DataError(
                    f"the panels differ in height: {frame.shape[0]} pixels ({panel.title!r}) and {frames[0].shape[0]}."
                )
        marked = [
            labelled(frame, LABEL) if label and panel.synthetic else frame
            for panel, frame in zip(panels, frames, strict=True)
        ]
        if bar is None:
            widths = [frame.shape[1] for frame in marked]
            bar = title_bar([panel.title for panel in panels], widths, title_height(marked[0].shape[0]))
        yield even_sized(np.vstack([bar, np.hstack(marked)]))


def even_sized(frame: np.ndarray) -> np.ndarray:
    """A frame of even size, as H.264 needs: an odd last row or column is repeated."""
    height, width = frame.shape[:2]
    return np.pad(frame, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")


def video_metadata(utterance: str, corpus: str, model: str, consent: str) -> dict[str, str]:
    """Metadata of a video: title, comment, and their parts under keys of their own."""
    permission = consent.strip() or "No statement of consent was given for this corpus."
    return {
        "title": f"{utterance}: synthetic talking head ({model})",
        "comment": (
            "This video is SYNTHETIC: where a panel is labelled or titled as reconstruction or prediction, the lower "
            f"face was made by a computer model ({model}, corpus {corpus}) and never moved like this. "
            f"Whose face it is and by what permission: {permission}"
        ),
        "synthetic": "yes",
        "model": model,
        "corpus": corpus,
        "consent": permission,
    }


def write_talking_head(
    path: str | Path,
    utterance: Utterance,
    recording: Recording,
    appearances: Mapping[str, tuple[np.ndarray, float]],
    speaker: Speaker,
    corpus: str,
    model: str,
    consent: str = "",
    settings: VideoSettings | None = None,
) -> None:
    """Write the video of one utterance: the original and one panel per stream of parameters, with the sound.

    Parameters
    ----------
    appearances : title of a panel -> appearance parameters v (frames, N) and their frame rate in Hz; they are resampled
        to the rate of the recording
    corpus, model, consent : for the metadata

    Raises
    ------
    DataError
        Streams of this utterance do not fit each other.
    RejectedUtterance
        The recording cannot be read.
    """
    metadata = video_metadata(utterance.id, corpus, model, consent)
    write_panels(path, utterance, recording, appearances, speaker, metadata, settings, original=True)


def write_panels(
    path: str | Path,
    utterance: Utterance,
    recording: Recording,
    appearances: Mapping[str, tuple[np.ndarray, float]],
    speaker: Speaker,
    metadata: Mapping[str, str],
    settings: VideoSettings | None = None,
    original: bool = False,
) -> None:
    """Write a video with one panel per stream of parameters and optionally the original.

    Frames are rendered and encoded one at a time, so memory does not grow with their number. Parameters and errors as
    :func:`write_talking_head`.

    Parameters
    ----------
    metadata : tags of the file
    original : whether the first panel shows the recording
    """
    settings = settings or VideoSettings()
    rate = probe(utterance.media).rate
    length = len(recording.landmarks)
    frames = read_frames(utterance.media, utterance.start, utterance.end)
    # Every panel gets its own iterator over the recorded frames, which are decoded once.
    sources = list(tee(frames, original + len(appearances)))
    panels = [Panel("original", sources.pop(0), synthetic=False)] if original else []
    for source, (title, (values, values_rate)) in zip(sources, appearances.items(), strict=True):
        values = resample(values, values_rate, rate, length)
        panels.append(Panel(title, synthetic_frames(source, values, recording, speaker, settings.rendering, rate=rate)))
    sound = read_audio(utterance.media, AUDIO_RATE, utterance.start, utterance.end)
    write_video(path, side_by_side(panels, settings.label), rate, sound, AUDIO_RATE, metadata)
