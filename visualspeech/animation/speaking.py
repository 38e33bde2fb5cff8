"""A talking head that says any text: from the appearance of a performance to a video on recorded frames.

A performance (:mod:`visualspeech.animation.performance`) and the background are processed a few seconds at a time, and
frames are rendered and encoded one at a time, so memory does not grow with the length.
"""

from collections.abc import Iterable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np

from visualspeech.animation.background import Background, eyes_closed
from visualspeech.animation.bundle import SpeakerBundle
from visualspeech.animation.frame_files import SOUND, barred, save_sound, saved, scaled
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
from visualspeech.media.webm import write_webm
from visualspeech.storage.files import replacing

PRESET = "veryfast"  # with slower presets of x264, encoding would take most of the time
_FRAMES_AT_A_TIME = 100  # frames whose lower face is positioned at a time
_TEXTURES_AT_A_TIME = 25  # textures decoded at a time, of 200 kB each


@dataclass(frozen=True)
class Scene:
    """The background of T frames.

    Parameters
    ----------
    mixes : frames of the background, or mixtures of two of them, for each of the T frames
    landmarks : (T, 68, 2) pixels
    pose : of the T frames
    clips : (T, C) shares of the background's recordings in each frame
    """

    mixes: list[Mix]
    landmarks: np.ndarray
    pose: Pose
    clips: np.ndarray


def scene(background: Background, frames: int, settings: WalkSettings | None = None) -> Scene:
    """A scene of the given number of frames."""
    return scene_of(background, list(islice(endless_background(background, settings), frames)))


def endless_background(background: Background, settings: WalkSettings | None = None) -> Iterator[Mix]:
    """Endless sequence of frames of a background (:func:`visualspeech.animation.walk.walk`)."""
    return walk(background.distances, background.clip, background.rate, settings, eyes_closed(background))


def scene_of(background: Background, mixes: list[Mix]) -> Scene:
    """The scene of a sequence of background frames; landmarks and poses are mixed in the same shares as the frames."""
    first, second = (np.array([getattr(mix, name) for mix in mixes]) for name in ("frame", "other"))
    share = np.array([mix.share for mix in mixes], np.float32)

    def mixed(values: np.ndarray) -> np.ndarray:
        weight = share.reshape(-1, *[1] * (values.ndim - 1))
        return (1 - weight) * values[first] + weight * values[second]

    return Scene(
        mixes,
        mixed(background.landmarks),
        Pose(mixed(background.pose.rotation), mixed(background.pose.translation)),
        mixed(np.eye(len(background.shapes), dtype=np.float32)[background.clip]),
    )


def place_in_scene(appearance: np.ndarray, bundle: SpeakerBundle, scene: Scene, settings: RenderSettings) -> Placement:
    """Positions of the lower face in the T frames of a scene, for an appearance (T, N) at the background's rate."""
    aam = bundle.speaker.aam
    shape = aam.shape_mean + appearance @ aam.shape_basis
    shape = shape + scene.clips @ bundle.background.shapes - aam.drift.shape
    points, rate = bundle.speaker.reference.points, bundle.background.rate
    return place(scene.landmarks, shape, scene.pose, bundle.speaker.head, points, settings, rate=rate)


def speaking_frames(
    appearance,
    bundle: SpeakerBundle,
    settings: SpeakSettings | None = None,
    rate: float | None = None,
    size: tuple[int, int] | None = None,
) -> Iterator[np.ndarray]:
    """Yield frames of the speaker with the lower face of an appearance, at the frame rate of the background.

    Parameters
    ----------
    appearance : (T, N), an array or a :class:`Spool`; it is read a few seconds at a time
    rate : of the appearance in Hz; default: that of the background
    size : (width, height) of the frames in pixels; default: that of the background. Where their shapes differ, the
        rest is black
    """
    settings = settings or SpeakSettings()
    parts = _parts(appearance, rate or bundle.background.rate, bundle, settings)
    for frame in stitched(parts, bundle.speaker.reference, settings.rendering, rate=bundle.background.rate):
        frame = scaled(frame, size)
        frame = barred(labelled(frame, LABEL) if settings.label else frame, size)
        height, width = frame.shape[:2]
        # H.264 halves the colour planes, so an odd last row or column is repeated.
        yield np.pad(frame, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")


def speak(
    path: str | Path | None,
    performance: Performance,
    bundle: SpeakerBundle,
    voice: str,
    settings: SpeakSettings | None = None,
    *,
    size: tuple[int, int] | None = None,
    frames_folder: str | Path | None = None,
) -> int:
    """Write the video of a performance with its sound, its frames as numbered PNGs, or both.

    Parameters
    ----------
    path : of the video; its suffix chooses the format: ``.webm`` is VP9 and Opus, any other H.264 and AAC in a
        container of that suffix (``.mp4``, ``.mov``). None: no video
    voice : source of the sound, for the metadata
    size : as for :func:`speaking_frames`
    frames_folder : for the PNGs and ``sound.wav``; an existing folder is replaced. None: no PNGs

    Returns
    -------
    Number of frames

    Raises
    ------
    StorageError
        A file cannot be written.
    """
    rate = bundle.background.rate
    count = frames_of(performance, rate)
    frames = speaking_frames(performance.appearance, bundle, settings, performance.rate, size)
    metadata = speech_metadata(performance.text, bundle, voice)
    with ExitStack() as made:
        if frames_folder is not None:
            folder = made.enter_context(replacing(frames_folder))
            folder.mkdir()
            save_sound(performance.sound(), performance.audio_rate, folder / SOUND)
            frames = saved(frames, folder, metadata)
        # One core renders frames while another one encodes earlier frames.
        frames = progress(prefetched(frames, 8), count, "frames")
        sound = performance.sound(), performance.audio_rate, metadata
        if path is None:
            for _ in frames:
                pass
        elif Path(path).suffix.lower() == ".webm":
            write_webm(path, frames, rate, *sound)
        else:
            write_video(path, frames, rate, *sound, preset=PRESET)
    return count


def speech_metadata(text: str, bundle: SpeakerBundle, voice: str) -> dict[str, str]:
    """Metadata of the video of a talking head: title, comment, and their parts under keys of their own."""
    permission = bundle.consent.strip() or "No statement of consent was given for this corpus."
    text = text or "(not given)"
    shortened = text if len(text) <= 1000 else text[:1000] + " ..."
    return {
        "title": f"synthetic talking head ({bundle.model}): {shortened[:80]}",
        "comment": (
            "This video is SYNTHETIC. The person shown never said this: the lower face was made by a computer model "
            f"({bundle.model}, corpus {bundle.corpus}) and put on recorded frames. Voice: {voice}. "
            f"Whose face it is and by what permission: {permission}"
        ),
        "synthetic": "yes",
        "voice": voice,
        "text": shortened,
        "model": bundle.model,
        "speaker": bundle.digest,
        "corpus": bundle.corpus,
        "consent": permission,
    }


def frames_of(performance: Performance, rate: float) -> int:
    """Number of frames of a performance in a video of ``rate`` Hz."""
    return _frames(len(performance.appearance), performance.rate, rate)


def _frames(count: int, rate: float, wanted: float) -> int:
    """Number of frames at the rate ``wanted`` for ``count`` frames of appearance at ``rate`` Hz."""
    return max(1, round(count / rate * wanted))


def _parts(appearance, rate: float, bundle: SpeakerBundle, settings: SpeakSettings) -> Iterator[tuple]:
    """For each frame the arguments of :func:`stitched`: recorded frame, recorded and target positions, texture."""
    background = bundle.background
    frames = _frames(len(appearance), rate, background.rate)
    # Positions are smoothed in time, so each block has a margin on either side as long as the smoothing reaches.
    margin = int(np.ceil(4 * settings.rendering.point_smoothing * background.rate)) + 1
    endless, mixes, since = endless_background(background, settings.walk), [], 0
    for first in range(0, frames, _FRAMES_AT_A_TIME):
        last = min(first + _FRAMES_AT_A_TIME, frames)
        begin, end = max(0, first - margin), min(frames, last + margin)
        mixes = mixes[begin - since :]
        mixes += islice(endless, end - begin - len(mixes))
        since = begin
        shown = scene_of(background, mixes)
        seen = _between(appearance, rate, background.rate, begin, end)
        placement = place_in_scene(seen, bundle, shown, settings.rendering)
        inner = slice(first - begin, last - begin)
        yield from zip(
            _mixed_frames(background, mixes[inner]),
            placement.recorded[inner],
            placement.target[inner],
            _textures(seen[inner], bundle, shown.clips[inner]),
            strict=True,
        )


def _between(appearance, rate: float, wanted: float, first: int, last: int) -> np.ndarray:
    """Frames ``first`` to ``last`` (exclusive) of an appearance, resampled from ``rate`` to the rate ``wanted``."""
    # Resampling interpolates neighbouring frames or averages those inside a frame, hence the margins.
    begin = max(0, int(np.floor(first / wanted * rate)) - 2)
    end = int(np.ceil(last / wanted * rate)) + 2
    # If the rates differ, the appearance may end before the last frame of the video; its last frame is then repeated.
    begin = min(begin, len(appearance) - 1)
    return resample(appearance[begin:end], rate, wanted, last - first, begin=first / wanted - begin / rate)


def _mixed_frames(background: Background, mixes: Iterable[Mix]) -> Iterator[np.ndarray]:
    import cv2

    for first, second, share in mixes:
        frame = background.frame(first)
        if share > 0 and second != first:
            frame = cv2.addWeighted(frame, 1 - share, background.frame(second), share, 0)
        yield frame


def _textures(appearance: np.ndarray, bundle: SpeakerBundle, clips: np.ndarray) -> Iterator[np.ndarray]:
    """Textures (3U,) in the light of the background's recordings, mixed in the shares ``clips`` (T, C)."""
    aam, background = bundle.speaker.aam, bundle.background
    for start in range(0, len(appearance), _TEXTURES_AT_A_TIME):
        rows = slice(start, start + _TEXTURES_AT_A_TIME)
        light = clips[rows] @ background.textures - aam.drift.texture
        yield from aam.decode(appearance[rows])[1] + light
