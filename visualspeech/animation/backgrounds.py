"""Backgrounds beside a speaker: any clip of the speaker, prepared once, onto which the speaker then speaks.

A prepared background is a folder with ``background.h5`` (:mod:`visualspeech.animation.background`) and
``background.json``, which holds the digests of the speaker's parts that it was made with. It contains no model.
"""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path

import numpy as np

from visualspeech.animation.background import MAX_FRAMES, Background, write_background
from visualspeech.animation.bundle import FILES, SpeakerBundle, parts_of
from visualspeech.animation.descriptions import read_description
from visualspeech.animation.showable import check_showable
from visualspeech.corpora.records import legal_id
from visualspeech.errors import CorpusError, DamagedFile, DataError, RejectedUtterance, StorageError
from visualspeech.face.aam.reference import Reference, sample_textures
from visualspeech.face.blinks import double_blinks
from visualspeech.face.drift import FaceReference
from visualspeech.face.head import HeadModel
from visualspeech.face.point_sets import to_vector
from visualspeech.face.pose import Pose, normalise
from visualspeech.face.screening import track_recording
from visualspeech.face.tracker import LandmarkSettings
from visualspeech.jobs import log
from visualspeech.media.reading import probe, read_frames
from visualspeech.provenance import file_digest
from visualspeech.storage.files import replacing, write_text
from visualspeech.storage.layouts import TEXT

KIND, VERSION = "visualspeech background", 1
ABOUT = "background.json"
TIED = ("aam", "reference", "head")  # parts of the speaker that a background is made with
MIN_SECONDS = 1.0  # of a clip; a shorter one is a still
#: Limits beyond which a clip shows another person (docs/speaking.md has what was measured): RMS distance of the points
#: of its mean face to the speaker's, as a share of the head's width; correlation of the textures' grey levels.
MAX_FACE_DISTANCE, MIN_CORRELATION = 0.025, 0.5
_TEXTURES_AT_A_TIME = 250
REMEDY = "Give another clip of the speaker."
AGAIN = "Prepare it again with `visualspeech background`."


@dataclass(frozen=True)
class Clip:
    """A clip as :func:`write_background` takes it, without its frames.

    Parameters
    ----------
    name : of the recording in the background
    media : path of the clip
    start, end : seconds of it that are used; an end of 0 means to its end
    landmarks : (T, 68, 2) pixels
    pose : of the T frames
    face : reference face
    rate : frame rate in Hz
    size : (width, height) in pixels
    """

    name: str
    media: Path
    start: float
    end: float
    landmarks: np.ndarray
    pose: Pose
    face: FaceReference
    rate: float
    size: tuple[int, int]

    def recorded(self) -> tuple:
        """What :func:`write_background` takes."""
        frames = read_frames(self.media, self.start, self.end)
        return self.name, self.media.name, frames, self.landmarks, self.pose, self.face, self.rate


def prepare_background(
    folder: str | Path,
    model: str | Path,
    videos: Sequence[Path],
    start: float = 0.0,
    end: float = 0.0,
    landmarks: LandmarkSettings | None = None,
    folder_of_tracker: str = "",
) -> Background:
    """Track, normalise, screen and store clips of a speaker as a background.

    Parameters
    ----------
    folder : to write; an existing one is replaced as a whole
    model : folder of the speaker
    videos : clips of one camera
    start, end : seconds of each clip that are used; an end of 0 means to its end
    landmarks : where landmarks come from; they should be those that the speaker was made with
    folder_of_tracker : in which the module of a tracker of one's own lies; empty: where Python finds modules

    Raises
    ------
    SettingError
        A tracker of one's own cannot be loaded.
    CorpusError
        A clip cannot be read, is broken or too short, or does not show the speaker's face.
    DataError
        The clips differ in size or frame rate, or have too many frames.
    StorageError
        The speaker cannot be loaded, or the folder cannot be written.
    """
    bundle = SpeakerBundle.load(model)
    part = start, end, bundle, landmarks, folder_of_tracker
    clips = [_clip(name, path, *part) for name, path in zip(_names(videos), videos, strict=True)]
    with replacing(folder) as made:
        made.mkdir()
        write_background(made / FILES["background"], (clip.recorded() for clip in clips))
        about = {
            "kind": KIND,
            "version": VERSION,
            "speaker": {part: parts_of(model)[part] for part in TIED},
            "background": file_digest(made / FILES["background"]),
            "clips": [clip.name for clip in clips],
        }
        write_text(made / ABOUT, json.dumps(about, indent=1, sort_keys=True) + "\n")
        background = Background.load(made / FILES["background"])
        with_frames(bundle, background, str(folder))
    return background


def load_background(bundle: SpeakerBundle, model: str | Path, folder: str | Path) -> SpeakerBundle:
    """A speaker before a prepared background.

    Parameters
    ----------
    bundle : the speaker, loaded from the folder ``model``
    folder : that :func:`prepare_background` wrote

    Raises
    ------
    StorageError
        It is no background, or is damaged.
    DataError
        It was prepared for another speaker.
    """
    folder = Path(folder)
    about = read_description(folder / ABOUT, "background", KIND, VERSION, _SCHEMA, _ORIGIN, AGAIN)
    path = folder / FILES["background"]
    if not path.is_file():
        raise StorageError(f"the background {folder} lacks {path.name}. Copy the whole folder. {AGAIN}")
    parts = parts_of(model)
    if any(about["speaker"][part] != parts[part] for part in TIED):
        raise DataError(
            f"the background {folder} was prepared for another speaker than {model}, or for an earlier version of it. "
            f"{AGAIN}"
        )
    if file_digest(path) != about["background"]:
        raise DamagedFile(path, "it was changed after it was prepared", AGAIN)
    return with_frames(bundle, Background.load(path), str(folder))


def only_recording(bundle: SpeakerBundle, name: str) -> SpeakerBundle:
    """A speaker before one recording of the own background; raises SettingError where there is none of this name."""
    return replace(bundle, background=bundle.background.only(name))


def with_frames(bundle: SpeakerBundle, background: Background, where: str) -> SpeakerBundle:
    """A speaker before another background, whose frames may have another size.

    Raises
    ------
    DataError
        The background is of another appearance model, or the speaker's head does not lie in it.
    """
    aam = bundle.speaker.aam
    if (background.shapes.shape[1], background.textures.shape[1]) != (len(aam.shape_mean), len(aam.texture_mean)):
        raise DataError(f"the background {where} is of another appearance model. {AGAIN}")
    speaker = replace(bundle.speaker, head=head_in(bundle.speaker.head, background.size))
    try:
        check_showable(Path(where), speaker, background, bundle.rest)
    except DataError as error:
        raise DataError(
            f"the background {where} does not fit the speaker: the face or the head would lie far outside its frames. "
            f"{REMEDY}"
        ) from error
    return replace(bundle, speaker=speaker, background=background)


def head_in(head: HeadModel, size: tuple[int, int]) -> HeadModel:
    """The head before a camera with frames of another size (width, height); its focal length is assumed as before."""
    centre = np.array([size[0] / 2, size[1] / 2])
    if np.allclose(centre, head.centre):
        return head
    return replace(head, focal=float(head.settings.focal_length * max(size)), centre=centre)


def likeness(face: FaceReference, bundle: SpeakerBundle) -> tuple[float, float]:
    """How far a reference face is from the speaker's: RMS distance of the points, as a share of the head's width, and
    correlation of the textures' grey levels."""
    aam = bundle.speaker.aam
    # Where recordings keep their drift, the reference is zero, and the mean face stands for it.
    kept = not aam.drift.texture.any()
    own = FaceReference(aam.shape_mean, aam.texture_mean) if kept else aam.drift
    shift = (face.shape - own.shape).reshape(2, -1)
    width = float(np.ptp(bundle.speaker.head.points3d[:, 0]))
    grey = [texture.reshape(3, -1).mean(axis=0, dtype=np.float64) for texture in (face.texture, own.texture)]
    with np.errstate(all="ignore"):  # a texture of one colour is no face
        correlation = float(np.nan_to_num(np.corrcoef(*grey)[0, 1]))
    return float(np.sqrt((shift**2).sum(axis=0).mean())) / width, correlation


def _clip(name: str, path: Path, *part) -> Clip:
    try:
        return _measured(name, path, *part)
    except RejectedUtterance as error:
        raise CorpusError(f"{path}: {error.reason}. {error.remedy or REMEDY}") from error


def _measured(
    name: str,
    path: Path,
    start: float,
    end: float,
    bundle: SpeakerBundle,
    settings: LandmarkSettings | None,
    folder_of_tracker: str,
) -> Clip:
    info = probe(path)
    seconds = (end or info.duration or np.inf) - start
    if np.isfinite(seconds) and seconds < MIN_SECONDS:
        raise RejectedUtterance(f"only {max(seconds, 0):.2f} s of video", f"Give at least {MIN_SECONDS:g} s.")
    if np.isfinite(seconds) and seconds * info.rate > MAX_FRAMES:
        raise RejectedUtterance(
            f"{seconds:.0f} s of video, more than the {MAX_FRAMES:,} frames of a background",
            "Choose a part of it with --start and --end.",
        )
    log.info("tracking %s", path)
    landmarks, rate = track_recording(path, start, end, settings, folder=folder_of_tracker)
    for finding in landmarks.findings:
        log.warning("%s: %s", path, finding)
    points, size = landmarks.points, (landmarks.width, landmarks.height)
    if len(points) < MIN_SECONDS * rate:
        raise RejectedUtterance(f"only {len(points) / rate:.2f} s of video", f"Give at least {MIN_SECONDS:g} s.")
    head = head_in(bundle.speaker.head, size)
    pose, frontal = normalise(points, head, head.settings, rate=rate)
    face = _mean_face(read_frames(path, start, end), points, frontal, bundle.speaker.reference)
    apart, alike = likeness(face, bundle)
    compared = f"points {apart:.1%} apart, correlation of the textures {alike:.2f}"
    log.info("%s: %d frames; compared with the speaker: %s", path, len(points), compared)
    if apart > MAX_FACE_DISTANCE or alike < MIN_CORRELATION:
        raise RejectedUtterance(
            f"the face is not this speaker's: its points lie {apart:.1%} of the head's width from the speaker's (at "
            f"most {MAX_FACE_DISTANCE:.1%}), its texture correlates at {alike:.2f} (at least {MIN_CORRELATION:g})",
            REMEDY,
        )
    if count := double_blinks(points, rate):
        log.warning("%s: %d double blink%s, which will be seen again and again", path, count, "s" * (count > 1))
    if not bundle.speaker.aam.drift.texture.any():  # this speaker's recordings keep their drift
        face = FaceReference(np.zeros_like(face.shape), np.zeros_like(face.texture))
    return Clip(name, path, start, end, points, pose, face, rate, size)


def _mean_face(frames: Iterator[np.ndarray], points: np.ndarray, frontal: np.ndarray, grid: Reference) -> FaceReference:
    """The mean face of a clip, as drift removal by ``clip_mean`` takes it; few textures are in memory at a time."""
    total = 0.0
    for start in range(0, len(points), _TEXTURES_AT_A_TIME):
        rows = points[start : start + _TEXTURES_AT_A_TIME]
        textures = sample_textures(islice(frames, len(rows)), grid.points.select(rows), grid)
        total = total + textures.sum(axis=0, dtype=np.float64)
    shape = to_vector(grid.points.select(frontal)).mean(axis=0, dtype=np.float64)
    return FaceReference(shape.astype(np.float32), (total / len(points)).astype(np.float32))


def _names(videos: Sequence[Path]) -> Iterator[str]:
    """Names of the clips in the background: those of the files, numbered where two have the same."""
    taken: set[str] = set()
    for path in videos:
        name = stem = legal_id(path.stem)
        number = 1
        while name in taken:
            number += 1
            name = f"{stem}-{number}"
        taken.add(name)
        yield name


_ORIGIN = "Give a folder that `visualspeech background` wrote, or the name of a recording of the speaker's background."
_SCHEMA = {
    "type": "object",
    "required": ["kind", "version", "speaker", "background", "clips"],
    "additionalProperties": False,
    "properties": {
        "kind": {"const": KIND},
        "version": {"const": VERSION},
        "speaker": {
            "type": "object",
            "required": list(TIED),
            "additionalProperties": False,
            "properties": dict.fromkeys(TIED, TEXT),
        },
        "background": TEXT,
        "clips": {"type": "array", "maxItems": MAX_FRAMES, "items": TEXT},
    },
}
