"""Background recordings: recorded frames of a speaker onto which a synthetic lower face is stitched.

A background is a few recordings in one HDF5 file. Every frame is a separate JPEG, so that all frames can be read in any
order at the same cost. Landmarks, head pose and the reference face of each recording are stored with them.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from visualspeech.errors import DataError, StorageError
from visualspeech.face.drift import FaceReference
from visualspeech.face.pose import Pose
from visualspeech.face.tracker import RIGID
from visualspeech.storage.arrays import ArrayReader, ArrayWriter

UPPER = np.r_[0:3, 14:17, 17:48]
"""Landmarks that do not move with speech but with blinks: temples, brows, nose, eyes."""

QUALITY = 97  # of the JPEGs; their error is smaller than that of the recording's own compression
_THUMBNAIL = 64  # pixels, width


@dataclass(frozen=True)
class Background:
    """n frames of C recordings of a speaker, one recording after the other.

    Parameters
    ----------
    jpegs : the n frames as JPEG files
    landmarks : (n, 68, 2) pixels
    pose : of the n frames
    clip : (n,) int, number of the recording of each frame, ascending
    shapes, textures : (C, 2N) and (C, 3U), the reference face of each recording
    media : path of each recording, for information
    rate : frame rate in Hz
    size : (width, height) in pixels
    """

    jpegs: tuple[bytes, ...]
    landmarks: np.ndarray
    pose: Pose
    clip: np.ndarray
    shapes: np.ndarray
    textures: np.ndarray
    media: tuple[str, ...]
    rate: float
    size: tuple[int, int]

    def __len__(self) -> int:
        return len(self.jpegs)

    def frame(self, index: int) -> np.ndarray:
        """One frame, (height, width, 3) uint8 RGB."""
        import cv2

        coded = np.frombuffer(self.jpegs[index], np.uint8)
        return cv2.cvtColor(cv2.imdecode(coded, cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)

    @classmethod
    def load(cls, path: str | Path) -> "Background":
        """The background that :func:`write_background` wrote.

        Raises
        ------
        StorageError
            The file is missing, damaged or of another kind.
        """
        with ArrayReader(path) as file:
            try:
                recordings = [(file[name], file.attributes(name), file.rate(name)) for name in file.ids]
                if not recordings:
                    raise KeyError("no recording")
                jpegs, clips = [], []
                for number, (arrays, _, _) in enumerate(recordings):
                    borders = np.r_[0, arrays["ends"]]
                    coded = arrays["pictures"].tobytes()
                    jpegs += [coded[a:b] for a, b in zip(borders[:-1], borders[1:], strict=True)]
                    clips += [number] * len(arrays["ends"])

                def joined(name: str) -> np.ndarray:
                    return np.concatenate([arrays[name] for arrays, _, _ in recordings])

                return cls(
                    jpegs=tuple(jpegs),
                    landmarks=joined("landmarks"),
                    pose=Pose(joined("rotation"), joined("translation")),
                    clip=np.array(clips),
                    shapes=np.stack([arrays["reference_shape"] for arrays, _, _ in recordings]),
                    textures=np.stack([arrays["reference_texture"] for arrays, _, _ in recordings]),
                    media=tuple(str(attributes["media"]) for _, attributes, _ in recordings),
                    rate=recordings[0][2],
                    size=(int(recordings[0][1]["width"]), int(recordings[0][1]["height"])),
                )
            except (KeyError, ValueError) as error:
                raise StorageError(f"{path} holds no background ({error}). Build the speaker again.") from error


def write_background(path: str | Path, clips: Iterable[tuple]) -> None:
    """Write a background, one recording at a time.

    Parameters
    ----------
    clips : for each recording (name, path of the media, frames (height, width, 3) uint8 RGB, landmarks (T, 68, 2),
        pose, reference face, frame rate in Hz); frames are taken one at a time

    Raises
    ------
    DataError
        The recordings differ in size or rate, a recording has more or fewer frames than landmarks or poses, or there
        is no recording.
    """
    import cv2

    first = None
    with ArrayWriter(path) as out:
        for name, media, frames, landmarks, pose, face, rate in clips:
            coded, size = [], None
            for frame in frames:
                size = (frame.shape[1], frame.shape[0])
                _, jpeg = cv2.imencode(
                    ".jpg", cv2.cvtColor(frame, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, QUALITY]
                )
                coded.append(jpeg.ravel())
            if len(coded) != len(landmarks) or len(coded) != len(pose):
                raise DataError(f"{media} has {len(coded)} frames, {len(landmarks)} of landmarks, {len(pose)} poses.")
            if first is None:
                first = size, rate
            if first != (size, rate):
                raise DataError(
                    f"{media} has {size} pixels at {rate:g} Hz, the first background recording {first[0]} at "
                    f"{first[1]:g} Hz; name recordings of one camera in `speak.background`."
                )
            arrays = {
                "pictures": np.concatenate(coded),
                "ends": np.cumsum([len(jpeg) for jpeg in coded]),
                "landmarks": np.asarray(landmarks, np.float32),
                "rotation": pose.rotation,
                "translation": pose.translation,
                "reference_shape": face.shape,
                "reference_texture": face.texture,
            }
            units = {"landmarks": "px", "pictures": "JPEG"}
            out.add(name, arrays, rate, units, media=str(media), width=size[0], height=size[1])
        if first is None:
            raise DataError("there is no recording to take the background from.")


def choose_recordings(faces: Iterable[tuple[str, np.ndarray, FaceReference]], seconds: float, rate: float) -> list[str]:
    """Names of recordings with similar head position and light, the most typical one first.

    Parameters
    ----------
    faces : name, landmarks (T, 68, 2) and reference face of each recording; taken one at a time
    seconds : minimum total duration, if there are enough recordings
    rate : frame rate in Hz

    Raises
    ------
    DataError
        There is no recording.
    """
    names, seats, lengths, lights = [], [], [], []
    for name, landmarks, face in faces:
        names.append(name)
        lengths.append(len(landmarks) / rate)
        seats.append(np.median(landmarks[:, RIGID], axis=0).ravel())
        lights.append(face.texture.reshape(3, -1).mean(axis=1) if face.texture.any() else np.zeros(3))
    if not names:
        raise DataError("there is no recording to take the background from: every utterance was rejected.")
    seats, lights = np.array(seats), np.array(lights)
    typical = np.argmin(_distances(seats, np.median(seats, axis=0)) + _distances(lights, np.median(lights, axis=0)))
    # One pixel counts as much as one grey level: both are just visible in a transition.
    apart = _distances(seats, seats[typical]) + _distances(lights, lights[typical])
    chosen, total = [], 0.0
    for number in np.argsort(apart, kind="stable"):
        if total >= seconds and chosen:
            break
        chosen.append(names[number])
        total += lengths[number]
    return chosen


def _distances(rows: np.ndarray, row: np.ndarray) -> np.ndarray:
    """Root-mean-square differences (n,) of rows (n, d) to one row (d,)."""
    return np.sqrt(((rows - row) ** 2).mean(axis=1))


def frame_distances(background: Background) -> np.ndarray:
    """Visual distances between all pairs of frames outside the lower face, (n, n) float32.

    The sum of the distances between the landmarks of the upper face and between the grey levels of thumbnails without
    the lower face, each in units of its median from one frame to the next. An ordinary step between frames is 2.
    """
    points = background.landmarks[:, UPPER].reshape(len(background), -1)
    thumbnails = np.stack(list(_thumbnails(background)))
    terms = [_all_distances(values.astype(np.float64)) for values in (points, thumbnails)]
    follows = np.nonzero(np.diff(background.clip) == 0)[0]
    result = np.zeros_like(terms[0])
    for term in terms:
        step = np.median(term[follows, follows + 1]) if len(follows) else 0.0
        result += term / step if step > 0 else term
    return result.astype(np.float32)


def eyes_closed(background: Background, share: float = 0.7) -> np.ndarray:
    """Whether the eyes are closed in each frame, (n,) bool: opened less than ``share`` of the median opening."""
    points = background.landmarks.astype(np.float64)

    def apart(a: int, b: int) -> np.ndarray:
        return np.linalg.norm(points[:, a] - points[:, b], axis=1)

    heights = apart(37, 41) + apart(38, 40) + apart(43, 47) + apart(44, 46)
    opening = heights / (apart(36, 39) + apart(42, 45))
    return opening < share * np.median(opening)


def _all_distances(rows: np.ndarray) -> np.ndarray:
    """Root-mean-square differences (n, n) between all pairs of rows (n, d)."""
    rows = rows - rows.mean(axis=0)
    squares = (rows**2).sum(axis=1)
    return np.sqrt(np.maximum(squares[:, None] + squares - 2 * rows @ rows.T, 0) / rows.shape[1])


def _thumbnails(background: Background) -> Iterator[np.ndarray]:
    """Thumbnails (m,) of the frames in grey levels, without the area that the lower face covers in any frame."""
    import cv2

    width, height = background.size
    small = (_THUMBNAIL, max(1, round(_THUMBNAIL * height / width)))
    hidden = np.zeros((height, width), np.uint8)
    for points in background.landmarks[:: max(1, len(background) // 50)]:
        outline = np.concatenate([points[2:15], points[35:30:-1]])
        cv2.fillConvexPoly(hidden, cv2.convexHull(np.rint(outline).astype(np.int32)), 255)
    seen = cv2.resize(hidden, small, interpolation=cv2.INTER_AREA) == 0
    for frame in range(len(background)):
        grey = cv2.cvtColor(background.frame(frame), cv2.COLOR_RGB2GRAY)
        yield cv2.resize(grey, small, interpolation=cv2.INTER_AREA)[seen]
