"""The face of a recording in a few calls: landmarks, head pose, shapes and textures, appearance model."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from visualspeech.api.speech import named
from visualspeech.errors import DataError
from visualspeech.face.aam.model import Aam, AamSettings, fit
from visualspeech.face.aam.reference import Reference, ReferenceSettings, fit_reference, sample_textures
from visualspeech.face.aam.rows import ArrayRows
from visualspeech.face.head import HeadModel, PoseSettings
from visualspeech.face.head import fit_head as fit_head_to_points
from visualspeech.face.point_sets import read_point_set, to_vector
from visualspeech.face.pose import normalise
from visualspeech.face.screening import ScreeningSettings, track_recording, track_screened
from visualspeech.face.tracker import LandmarkSettings

#: Point set of Fan et al. (2015): lips, jaw and nose.
POINTS = "lower_face_51"


@dataclass(frozen=True)
class TrackedFace:
    """The landmarks of one recording.

    Parameters
    ----------
    points : (T, 68, 2) float32, pixels of the frame (x right, y down), iBUG order; interpolated where no face was found
    detected : (T,) bool, False where the points are interpolated
    rate : frame rate in Hz; frame i stands for (i + 0.5) / rate seconds
    size : (width, height) of the frames in pixels
    findings : warnings, one sentence each
    """

    points: np.ndarray
    detected: np.ndarray
    rate: float
    size: tuple[int, int]
    findings: tuple[str, ...] = ()


@dataclass(frozen=True)
class NormalisedFace:
    """The landmarks of one recording without the movement of the head.

    Parameters
    ----------
    points : (T, 68, 2) pixels of the normalised face, which is seen from the front
    rotation : (T, 3) head rotation, Rodrigues vectors in radians
    translation : (T, 3) head position in units of the head
    head : the 3-D head
    rate : frame rate in Hz
    """

    points: np.ndarray
    rotation: np.ndarray
    translation: np.ndarray
    head: HeadModel
    rate: float


@dataclass(frozen=True)
class SampledFaces:
    """Shapes and textures of one recording: what an AAM is fitted to and encodes.

    Parameters
    ----------
    shapes : (T, 2N) pixels of the normalised face, x_1 ... x_N, y_1 ... y_N
    textures : (T, 3U) uint8 grey levels, all red, then green, then blue
    reference : mean shape and texture grid of U pixels
    rate : frame rate in Hz
    """

    shapes: np.ndarray
    textures: np.ndarray
    reference: Reference
    rate: float


def track(
    recording: str | Path | Iterable[np.ndarray],
    *,
    rate: float | None = None,
    start: float = 0.0,
    end: float = 0.0,
    settings: LandmarkSettings | None = None,
    screening: ScreeningSettings | None = None,
) -> TrackedFace:
    """The 68 landmarks of the face in every frame of a recording.

    Parameters
    ----------
    recording : path of a video, or its frames (height, width, 3) uint8 RGB
    rate : frame rate in Hz of frames; a video says its own
    start, end : segment of a video in seconds; an ``end`` of 0 means to its end
    settings, screening : detection and tracking; limits beyond which a recording counts as broken

    Raises
    ------
    RejectedUtterance
        The recording cannot be read, is broken or shows no usable face.
    DataError
        Frames were given without their rate.
    """
    if not isinstance(recording, str | Path) and not (rate and rate > 0):
        raise DataError("frames need their frame rate in Hz: track(frames, rate=25).")
    with named(recording):
        if isinstance(recording, str | Path):
            found, rate = track_recording(recording, start, end, settings, screening)
        else:
            found = track_screened(recording, rate, settings, screening)
    return TrackedFace(found.points, found.detected, float(rate), (found.width, found.height), found.findings)


def fit_head(tracked: TrackedFace | Sequence[TrackedFace], settings: PoseSettings | None = None) -> HeadModel:
    """The 3-D head of a speaker, from the landmarks of one or more recordings by one camera.

    Raises
    ------
    DataError
        The recordings differ in frame size, or there is none.
    """
    given = [tracked] if isinstance(tracked, TrackedFace) else list(tracked)
    if not given:
        raise DataError("a head is fitted to at least one tracked recording.")
    if len({one.size for one in given}) > 1:
        sizes = ", ".join(sorted({"{}x{}".format(*one.size) for one in given}))
        raise DataError(f"the recordings have different frame sizes ({sizes}); fit a head to those of one size.")
    return fit_head_to_points(np.concatenate([one.points[one.detected] for one in given]), given[0].size, settings)


def normalise_pose(
    tracked: TrackedFace, head: HeadModel | None = None, settings: PoseSettings | None = None
) -> NormalisedFace:
    """Landmarks of a recording without the movement of the head, and the head's pose.

    Parameters
    ----------
    head : of the speaker; None: it is fitted to this recording
    settings : smoothing of the pose; default: that of the head

    Raises
    ------
    RejectedUtterance
        There is no pose under which the head shows these landmarks.
    """
    head = head or fit_head(tracked, settings)
    pose, points = normalise(tracked.points, head, settings or head.settings, rate=tracked.rate)
    return NormalisedFace(points, pose.rotation, pose.translation, head, tracked.rate)


def sample_faces(
    recording: str | Path | Iterable[np.ndarray],
    tracked: TrackedFace,
    normalised: NormalisedFace,
    *,
    start: float = 0.0,
    end: float = 0.0,
    reference: Reference | None = None,
    points: str = POINTS,
    settings: ReferenceSettings | None = None,
) -> SampledFaces:
    """Shapes and textures of the faces of a tracked recording.

    Parameters
    ----------
    recording, start, end : as for :func:`track`
    reference : mean shape and texture grid, where several recordings share one; None: fitted to this recording
    points : name of the point set of a new reference, ``lower_face_51`` (Fan 2015) or ``lower_face_34``
    settings : of a new reference, such as its number of pixels

    Raises
    ------
    RejectedUtterance
        The recording cannot be read.
    DataError
        The recording has another number of frames than the landmarks.
    SettingError
        There is no such point set.
    """
    reference = reference or fit_reference(
        [read_point_set(points).select(normalised.points)], read_point_set(points), settings
    )
    frames = recording
    if isinstance(recording, str | Path):
        from visualspeech.media.reading import read_frames

        frames = read_frames(recording, start, end)
    with named(recording):
        textures = sample_textures(frames, reference.points.select(tracked.points), reference)
    return SampledFaces(to_vector(reference.points.select(normalised.points)), textures, reference, tracked.rate)


def fit_aam(
    shapes: np.ndarray, textures: np.ndarray, *, points: str = POINTS, settings: AamSettings | None = None
) -> Aam:
    """An active appearance model of faces (Fan 2015, Eq. 2-8).

    ``aam.encode(shapes, textures).appearance`` are the parameters (T, N) of faces, ``aam.decode(parameters)`` the
    shapes and textures of parameters.

    Parameters
    ----------
    shapes : (J, 2N) shape vectors, or (J, N, 2) points, in pixels of the normalised face
    textures : (J, 3U) grey levels, any number type
    points : name of the point set, of N points
    settings : components of the analyses

    Raises
    ------
    DataError
        Shapes and textures do not fit each other or the point set, are not finite, or nothing varies.
    SettingError
        More components, or more energy, than the data can give; or there is no such point set.
    """
    known, settings = read_point_set(points), settings or AamSettings()
    shapes, textures = np.asarray(shapes), np.asarray(textures)
    if shapes.ndim == 3 and shapes.shape[2] == 2:
        shapes = to_vector(shapes)
    if textures.ndim != 2 or textures.shape[1] % 3 or not textures.size:
        raise DataError(f"textures are (faces, 3 x pixels), not {textures.shape}.")
    if not (np.isfinite(shapes).all() and np.isfinite(textures).all()):
        raise DataError("a shape or texture has a value that is no finite number.")
    settings.check_possible(len(shapes), known.freedom)
    return fit(shapes, ArrayRows(textures), known, settings)
