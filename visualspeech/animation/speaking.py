"""A talking head that says any text: a performance's appearance -> lower face on recorded pictures -> video.

Of a performance (:mod:`visualspeech.animation.performance`) and of the way through the background a few seconds at a
time are looked at, and the pictures are made and encoded one at a time: memory does not grow with the length.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np

from visualspeech.animation.background import Background, eyes_closed, frame_distances
from visualspeech.animation.bundle import SpeakerBundle
from visualspeech.animation.label import labelled
from visualspeech.animation.performance import Performance
from visualspeech.animation.rendering import Placement, RenderSettings, place, stitched
from visualspeech.animation.speaking_settings import SpeakSettings
from visualspeech.animation.video import LABEL
from visualspeech.animation.walk import Mix, WalkSettings, walk
from visualspeech.face.pose import Pose
from visualspeech.features.resampling import resample
from visualspeech.jobs import progress
from visualspeech.media.encoding import write_video
from visualspeech.media.prefetching import prefetched

PRESET = "veryfast"  # of the encoder, which would else take most of the time
_PLACED = 100  # frames placed at a time
_DECODED = 25  # textures decoded at a time: each is 200 kB


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
    """A way of so many frames through a background, with what was measured along it."""
    return scene_along(background, list(islice(way_through(background, settings), frames)))


def way_through(background: Background, settings: WalkSettings | None = None) -> Iterator[Mix]:
    """Frames of a background without end."""
    return walk(frame_distances(background), background.clip, background.rate, settings, eyes_closed(background))


def scene_along(background: Background, way: list[Mix]) -> Scene:
    """What was measured along a way through a background, mixed as the pictures are."""
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
    points, rate = bundle.speaker.reference.points, bundle.background.rate
    return place(scene.landmarks, shape, scene.pose, bundle.speaker.head, points, settings, rate=rate)


def speaking_frames(
    appearance, bundle: SpeakerBundle, settings: SpeakSettings | None = None, rate: float | None = None
) -> Iterator[np.ndarray]:
    """Pictures of the speaker with the lower face of an appearance, one at a time.

    Parameters
    ----------
    appearance : (T, N), an array or a :class:`Spool`; it is read a few seconds at a time
    rate : of the appearance, frames a second; default: that of the background, which is that of the pictures
    """
    settings = settings or SpeakSettings()
    parts = _parts(appearance, rate or bundle.background.rate, bundle, settings)
    for picture in stitched(parts, bundle.speaker.reference, settings.rendering, rate=bundle.background.rate):
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
    frames = _frames(len(performance.appearance), performance.rate, rate)
    pictures = speaking_frames(performance.appearance, bundle, settings, performance.rate)
    # Pictures are made on one core while the last ones are encoded on another.
    pictures = progress(prefetched(pictures, 8), frames, "frames")
    metadata = speech_metadata(performance.text, bundle, voice)
    write_video(path, pictures, rate, performance.sound(), performance.audio_rate, metadata, preset=PRESET)


def speech_metadata(text: str, bundle: SpeakerBundle, voice: str) -> dict[str, str]:
    """What the video of a talking head says of itself: title, comment and one key for each part of it."""
    permission = bundle.consent.strip() or "No statement of consent was given for this corpus."
    text = text or "(not given)"
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


def _frames(count: int, rate: float, wanted: float) -> int:
    """Pictures at the ``wanted`` rate of so many frames of appearance."""
    return max(1, round(count / rate * wanted))


def _parts(appearance, rate: float, bundle: SpeakerBundle, settings: SpeakSettings) -> Iterator[tuple]:
    """Of each frame what :func:`stitched` wants: recorded picture, place there, place wanted, texture."""
    background = bundle.background
    frames = _frames(len(appearance), rate, background.rate)
    # Places are smoothed in time: what is cut off beside the frames placed at a time reaches as far as the smoothing.
    margin = int(np.ceil(4 * settings.rendering.point_smoothing * background.rate)) + 1
    endless, way, since = way_through(background, settings.walk), [], 0
    for first in range(0, frames, _PLACED):
        last = min(first + _PLACED, frames)
        begin, end = max(0, first - margin), min(frames, last + margin)
        way = way[begin - since :]
        way += islice(endless, end - begin - len(way))
        since = begin
        shown = scene_along(background, way)
        seen = _between(appearance, rate, background.rate, begin, end)
        placement = placed(seen, bundle, shown, settings.rendering)
        inner = slice(first - begin, last - begin)
        yield from zip(
            _mixed_pictures(background, way[inner]),
            placement.recorded[inner],
            placement.target[inner],
            _textures(seen[inner], bundle, shown.clips[inner]),
            strict=True,
        )


def _between(appearance, rate: float, wanted: float, first: int, last: int) -> np.ndarray:
    """Frames ``first`` to ``last`` at the ``wanted`` rate of an appearance at another."""
    # A frame is read off its neighbours, or the mean of those inside it.
    begin = max(0, int(np.floor(first / wanted * rate)) - 2)
    end = int(np.ceil(last / wanted * rate)) + 2
    # An appearance ends before its last picture does, where the rates differ; its last frame stays.
    begin = min(begin, len(appearance) - 1)
    return resample(appearance[begin:end], rate, wanted, last - first, begin=first / wanted - begin / rate)


def _mixed_pictures(background: Background, way: Iterable[Mix]) -> Iterator[np.ndarray]:
    import cv2

    for frame, other, share in way:
        picture = background.picture(frame)
        if share > 0 and other != frame:
            picture = cv2.addWeighted(picture, 1 - share, background.picture(other), share, 0)
        yield picture


def _textures(appearance: np.ndarray, bundle: SpeakerBundle, clips: np.ndarray) -> Iterator[np.ndarray]:
    """Textures in the light of the recordings, of which the (T, C) shares are given."""
    aam, background = bundle.speaker.aam, bundle.background
    for start in range(0, len(appearance), _DECODED):
        rows = slice(start, start + _DECODED)
        light = clips[rows] @ background.textures - aam.drift.texture
        yield from aam.decode(appearance[rows])[1] + light
