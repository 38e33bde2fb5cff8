"""A talking head that says any text: labels -> network -> appearance -> lower face on recorded pictures -> video.

Sentence after sentence is spoken and predicted; then the pictures are made and encoded one at a time. What is kept of a
text is its sound and some kilobytes a frame (places and parameters), never pictures or textures.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from itertools import islice
from pathlib import Path

import numpy as np

from visualspeech.animation.background import Background, frame_distances
from visualspeech.animation.bundle import SpeakerBundle
from visualspeech.animation.label import labelled
from visualspeech.animation.rendering import Placement, RenderSettings, place, talking_head
from visualspeech.animation.video import LABEL
from visualspeech.animation.walk import Mix, WalkSettings, walk
from visualspeech.errors import DataError, SettingError
from visualspeech.face.pose import Pose
from visualspeech.features.resampling import resample
from visualspeech.features.richer import full_labels
from visualspeech.jobs import log, progress
from visualspeech.media import write_video
from visualspeech.models.network import Network
from visualspeech.prefetching import prefetched
from visualspeech.speech.alignment import Alignment, to_table
from visualspeech.speech.phones import SILENCE
from visualspeech.speech.spoken import Spoken
from visualspeech.speech.substitutes import substitutes
from visualspeech.timing import frame_times

PRESET = "veryfast"  # of the encoder, which would else take most of the time
_BLOCK = 25  # textures decoded at a time


@dataclass(frozen=True)
class SpeakSettings:
    """How a talking head speaks.

    Parameters
    ----------
    label : write the word "synthetic" small into every picture
    rest : seconds from the border of a pause until the face is wholly at rest; speech goes into a pause and comes
        out of it by the network alone, and inside it the mouth is that of the speaker in silence
    walk : the way through the background
    rendering : how faces are stitched
    """

    label: bool = True
    rest: float = 0.2
    walk: WalkSettings = field(default_factory=WalkSettings)
    rendering: RenderSettings = field(default_factory=RenderSettings)

    def __post_init__(self) -> None:
        if not self.rest > 0:
            raise SettingError(f"rest is {self.rest!r}; give seconds above 0 (0.2 serves).")


@dataclass(frozen=True)
class Performance:
    """What is said and how the face moves, before any picture is made.

    Parameters
    ----------
    text : all of it
    samples : (n,) float32, mono, in [-1, 1]
    audio_rate : samples a second
    appearance : (T, N) at ``rate``
    rate : frames a second
    """

    text: str
    samples: np.ndarray
    audio_rate: int
    appearance: np.ndarray
    rate: float

    @property
    def seconds(self) -> float:
        """Length of the pictures."""
        return len(self.appearance) / self.rate


def perform(
    spoken: Iterable[Spoken], network: Network, rest: np.ndarray, settings: SpeakSettings | None = None
) -> Performance:
    """Predict the face of everything that is said, sentence by sentence.

    Parameters
    ----------
    spoken : sentences in their order
    rest : (N,) appearance in silence

    Raises
    ------
    SettingError
        The model knows none of the phones.
    DataError
        The sentences differ in their sound's rate, or there are none.
    """
    settings = settings or SpeakSettings()
    texts, sounds, faces, audio_rate = [], [], [], 0
    told: set[str] = set()
    samples = frames = 0
    for one in spoken:
        if audio_rate and one.rate != audio_rate:
            raise DataError(f"one sentence is sound of {one.rate} Hz, another of {audio_rate} Hz.")
        audio_rate = one.rate
        alignment, replaced = in_phones_of(one.alignment, network.phones)
        if set(replaced) - told:
            told |= set(replaced)
            log.info(
                "the model has not learnt some phones of this text: %s",
                ", ".join(f"{other} is shown for {phone}" for phone, other in sorted(replaced.items())),
            )
        # Every sentence ends with a frame: what is missing of its last is silence.
        count = max(1, int(np.ceil(len(one.samples) / one.rate * network.rate - 1e-6)))
        frames += count
        length = round(frames * one.rate / network.rate) - samples
        samples += length
        sounds.append(np.pad(one.samples, (0, max(0, length - len(one.samples))))[:length].astype(np.float32))
        faces.append(face_of(alignment, count, network, rest, settings.rest))
        texts.append(one.text)
    if not faces:
        raise DataError("there is nothing to say.")
    return Performance(" ".join(texts), np.concatenate(sounds), audio_rate, np.concatenate(faces), float(network.rate))


def in_phones_of(alignment: Alignment, phones) -> tuple[Alignment, dict[str, str]]:
    """An alignment in the phones that a model knows, and which phones were replaced by which.

    Raises
    ------
    SettingError
        The model's phones are of another kind.
    """
    replaced = substitutes((one.label for one in alignment.phones), phones)
    if not replaced:
        return alignment, {}
    renamed = tuple(replace(one, label=replaced.get(one.label, one.label)) for one in alignment.phones)
    return replace(alignment, phones=renamed), replaced


def face_of(alignment: Alignment, frames: int, network: Network, rest: np.ndarray, ramp: float) -> np.ndarray:
    """Appearance (frames, N) of one sentence: the network's, and in pauses the face at rest.

    Parameters
    ----------
    ramp : seconds from the border of a pause to the face at rest
    """
    labels = full_labels(to_table({"": alignment}), frames, network.rate, network.phones, network.parts)
    weight = pause_weights(alignment, frames, network.rate, ramp)[:, None]
    return ((1 - weight) * network.predict(labels) + weight * rest).astype(np.float32)


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


@dataclass(frozen=True)
class Scene:
    """The background of T frames.

    Parameters
    ----------
    way : T frames of the background
    landmarks : (T, 68, 2) pixels
    pose : of the T frames
    clips : (T, C) shares of the background's recordings in each frame
    """

    way: list[Mix]
    landmarks: np.ndarray
    pose: Pose
    clips: np.ndarray


def scene(background: Background, frames: int, settings: WalkSettings | None = None) -> Scene:
    """A way of so many frames through a background, with what was measured along it mixed as the pictures are."""
    way = list(islice(walk(frame_distances(background), background.clip, background.rate, settings), frames))
    first, second = (np.array([getattr(mix, name) for mix in way]) for name in ("frame", "other"))
    share = np.array([mix.share for mix in way], np.float32)

    def mixed(values: np.ndarray) -> np.ndarray:
        part = share.reshape(-1, *[1] * (values.ndim - 1))
        return (1 - part) * values[first] + part * values[second]

    return Scene(
        way,
        mixed(background.landmarks),
        Pose(mixed(background.pose.rotation), mixed(background.pose.translation)),
        mixed(np.eye(len(background.shapes), dtype=np.float32)[background.clip]),
    )


def placed(appearance: np.ndarray, bundle: SpeakerBundle, scene: Scene, settings: RenderSettings) -> Placement:
    """Where the lower face is in the T frames of a scene, given the appearance (T, N) at the scene's rate."""
    aam = bundle.speaker.aam
    shape = aam.shape_mean + appearance @ aam.shape_basis
    shape = shape + scene.clips @ bundle.background.shapes - aam.drift.shape
    return place(scene.landmarks, shape, scene.pose, bundle.speaker.head, settings)


def speaking_frames(
    appearance: np.ndarray, bundle: SpeakerBundle, settings: SpeakSettings | None = None
) -> Iterator[np.ndarray]:
    """Pictures of the speaker with the lower face of an appearance (T, N) at the background's rate, one at a time."""
    settings = settings or SpeakSettings()
    shown = scene(bundle.background, len(appearance), settings.walk)
    placement = placed(appearance, bundle, shown, settings.rendering)
    pictures = _mixed_pictures(bundle.background, shown.way)
    textures = _textures(appearance, bundle, shown)
    for picture in talking_head(pictures, placement, textures, bundle.speaker.reference, settings.rendering):
        picture = labelled(picture, LABEL) if settings.label else picture
        height, width = picture.shape[:2]
        # H.264 halves the colour planes: an odd last row or column is shown twice.
        yield np.pad(picture, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")


def speak(
    path: str | Path,
    performance: Performance,
    bundle: SpeakerBundle,
    voice: str,
    settings: SpeakSettings | None = None,
) -> None:
    """Write the video of a performance, with its sound.

    Parameters
    ----------
    voice : where the sound is from, for the metadata
    """
    rate = bundle.background.rate
    frames = max(1, round(performance.seconds * rate))
    appearance = resample(performance.appearance, performance.rate, rate, frames)
    # Pictures are made on one core while the last ones are encoded on another.
    pictures = progress(prefetched(speaking_frames(appearance, bundle, settings), 8), frames, "frames")
    metadata = speech_metadata(performance.text, bundle, voice)
    write_video(path, pictures, rate, performance.samples, performance.audio_rate, metadata, preset=PRESET)


def speech_metadata(text: str, bundle: SpeakerBundle, voice: str) -> dict[str, str]:
    """What the video of a talking head says of itself: title, comment and one key for each part of it."""
    permission = bundle.consent.strip() or "No statement of consent was given for this corpus."
    said = text if len(text) <= 1000 else text[:1000] + " ..."
    return {
        "title": f"synthetic talking head ({bundle.model}): {said[:80]}",
        "comment": (
            "This video is SYNTHETIC. The person shown never said this: the lower face was made by a computer model "
            f"({bundle.model}, corpus {bundle.corpus}) and put on recorded pictures. Voice: {voice}. "
            f"Whose face it is and by what permission: {permission}"
        ),
        "synthetic": "yes",
        "voice": voice,
        "text": said,
        "model": bundle.model,
        "speaker": bundle.digest,
        "corpus": bundle.corpus,
        "consent": permission,
    }


def _mixed_pictures(background: Background, way: Iterable[Mix]) -> Iterator[np.ndarray]:
    import cv2

    for frame, other, share in way:
        picture = background.picture(frame)
        if share > 0 and other != frame:
            picture = cv2.addWeighted(picture, 1 - share, background.picture(other), share, 0)
        yield picture


def _textures(appearance: np.ndarray, bundle: SpeakerBundle, scene: Scene) -> Iterator[np.ndarray]:
    """Textures in the light of the recordings, a few decoded at a time: all of them would be 72 kB a frame."""
    aam, background = bundle.speaker.aam, bundle.background
    for start in range(0, len(appearance), _BLOCK):
        rows = slice(start, start + _BLOCK)
        light = scene.clips[rows] @ background.textures - aam.drift.texture
        yield from aam.decode(appearance[rows])[1] + light
