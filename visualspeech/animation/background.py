"""Recorded pictures of a speaker that a talking head is put on: head, eyes, hair and background are theirs.

A background is a few recordings in one HDF5 file: every picture as a JPEG of its own, so that any frame can be had at
any time at the same cost, with landmarks, pose, and the reference face of its recording.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from visualspeech.errors import DataError, StorageError
from visualspeech.face.drift import FaceReference
from visualspeech.face.pose import Pose
from visualspeech.face.tracker import RIGID
from visualspeech.storage import ArrayReader, ArrayWriter

UPPER = np.r_[0:3, 14:17, 17:48]
"""Landmarks that speech does not move: temples, brows, nose, eyes. A blink is seen in them."""

QUALITY = 97  # of the JPEGs; their error stays below that of the recording's own compression
_THUMBNAIL = 64  # pixels, width


@dataclass(frozen=True)
class Background:
    """Pictures of a speaker, n frames of C recordings one after the other.

    Parameters
    ----------
    pictures : JPEG of each frame, n entries
    landmarks : (n, 68, 2) pixels
    pose : of the n frames
    clip : (n,) int, the recording of each frame, ascending
    shapes, textures : (C, 2N) and (C, 3U), the reference face of each recording
    media : path of each recording, for people
    rate : frames a second
    size : (width, height) in pixels
    """

    pictures: tuple[bytes, ...]
    landmarks: np.ndarray
    pose: Pose
    clip: np.ndarray
    shapes: np.ndarray
    textures: np.ndarray
    media: tuple[str, ...]
    rate: float
    size: tuple[int, int]

    def __len__(self) -> int:
        return len(self.pictures)

    def picture(self, frame: int) -> np.ndarray:
        """One frame, (height, width, 3) uint8 RGB."""
        import cv2

        coded = np.frombuffer(self.pictures[frame], np.uint8)
        return cv2.cvtColor(cv2.imdecode(coded, cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)

    @classmethod
    def load(cls, path: str | Path) -> "Background":
        """Read what :func:`write_background` wrote.

        Raises
        ------
        StorageError
            The file is missing, damaged or of another kind.
        """
        with ArrayReader(path) as file:
            try:
                parts = [(file[name], file.attributes(name), file.rate(name)) for name in file.ids]
                if not parts:
                    raise KeyError("no recording")
                pictures, clips = [], []
                for number, (arrays, _, _) in enumerate(parts):
                    borders = np.r_[0, arrays["ends"]]
                    coded = arrays["pictures"].tobytes()
                    pictures += [coded[a:b] for a, b in zip(borders[:-1], borders[1:], strict=True)]
                    clips += [number] * len(arrays["ends"])

                def joined(name: str) -> np.ndarray:
                    return np.concatenate([arrays[name] for arrays, _, _ in parts])

                return cls(
                    pictures=tuple(pictures),
                    landmarks=joined("landmarks"),
                    pose=Pose(joined("rotation"), joined("translation")),
                    clip=np.array(clips),
                    shapes=np.stack([arrays["reference_shape"] for arrays, _, _ in parts]),
                    textures=np.stack([arrays["reference_texture"] for arrays, _, _ in parts]),
                    media=tuple(str(attributes["media"]) for _, attributes, _ in parts),
                    rate=parts[0][2],
                    size=(int(parts[0][1]["width"]), int(parts[0][1]["height"])),
                )
            except (KeyError, ValueError) as error:
                raise StorageError(f"{path} holds no background pictures ({error}). Make the speaker anew.") from error


def write_background(path: str | Path, clips: Iterable[tuple]) -> None:
    """Write a background, one recording at a time.

    Parameters
    ----------
    clips : of each recording (name, path of the media, frames (height, width, 3) uint8 RGB one at a time, landmarks
        (T, 68, 2), pose, reference face, frame rate in Hz)

    Raises
    ------
    DataError
        The recordings differ in size or rate, or one has not as many frames as landmarks.
    """
    import cv2

    kind = None
    with ArrayWriter(path) as out:
        for name, media, frames, landmarks, pose, face, rate in clips:
            coded, size = [], None
            for frame in frames:
                size = (frame.shape[1], frame.shape[0])
                good, one = cv2.imencode(
                    ".jpg", cv2.cvtColor(frame, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, QUALITY]
                )
                coded.append(one.ravel())
            if len(coded) != len(landmarks) or len(coded) != len(pose):
                raise DataError(f"{media} has {len(coded)} frames, {len(landmarks)} of landmarks, {len(pose)} poses.")
            if kind is None:
                kind = size, rate
            if kind != (size, rate):
                raise DataError(
                    f"{media} is {size} at {rate:g} frames/s, the first background recording is {kind[0]} at "
                    f"{kind[1]:g}; name recordings of one camera in speak.background."
                )
            arrays = {
                "pictures": np.concatenate(coded),
                "ends": np.cumsum([len(one) for one in coded]),
                "landmarks": np.asarray(landmarks, np.float32),
                "rotation": pose.rotation,
                "translation": pose.translation,
                "reference_shape": face.shape,
                "reference_texture": face.texture,
            }
            units = {"landmarks": "px", "pictures": "JPEG"}
            out.add(name, arrays, rate, units, media=str(media), width=size[0], height=size[1])
        if kind is None:
            raise DataError("there is no recording to take the background from.")


def choose_recordings(faces: Iterable[tuple[str, np.ndarray, FaceReference]], seconds: float, rate: float) -> list[str]:
    """Names of recordings that go together: the head at one place, in one light; the most usual one first.

    Parameters
    ----------
    faces : of each recording its name, landmarks (T, 68, 2) and reference face; read one at a time
    seconds : how much is wanted; recordings are taken until there is as much

    Raises
    ------
    DataError
        There are none.
    """
    names, seats, lengths, lights = [], [], [], []
    for name, landmarks, face in faces:
        names.append(name)
        lengths.append(len(landmarks) / rate)
        # Where the head begins and ends, too: recordings that wander cannot be joined anywhere.
        seats.append(np.median(landmarks[:, RIGID], axis=0).ravel())
        lights.append(face.texture.reshape(3, -1).mean(axis=1) if face.texture.any() else np.zeros(3))
    if not names:
        raise DataError("there is no recording to take the background from: every utterance was rejected.")
    seats, lights = np.array(seats), np.array(lights)
    usual = np.argmin(_distances(seats, np.median(seats, axis=0)) + _distances(lights, np.median(lights, axis=0)))
    # Pixels and grey levels weigh alike: a pixel aside and a level brighter can both just be seen in a change.
    apart = _distances(seats, seats[usual]) + _distances(lights, lights[usual])
    chosen, total = [], 0.0
    for number in np.argsort(apart, kind="stable"):
        if total >= seconds and chosen:
            break
        chosen.append(names[number])
        total += lengths[number]
    return chosen


def _distances(rows: np.ndarray, row: np.ndarray) -> np.ndarray:
    return np.sqrt(((rows - row) ** 2).mean(axis=1))


def frame_distances(background: Background) -> np.ndarray:
    """How differently any two frames look where nothing is painted over, (n, n) float32.

    The sum of the distance of the landmarks of the upper face and of the grey levels of small pictures without the
    lower face, each in units of its own median from one frame to the next: a value of 2 is an ordinary step.
    """
    points = background.landmarks[:, UPPER].reshape(len(background), -1)
    pictures = np.stack(list(_thumbnails(background)))
    parts = [_all_distances(values.astype(np.float64)) for values in (points, pictures)]
    follows = np.nonzero(np.diff(background.clip) == 0)[0]
    result = np.zeros_like(parts[0])
    for part in parts:
        step = np.median(part[follows, follows + 1]) if len(follows) else 0.0
        result += part / step if step > 0 else part
    return result.astype(np.float32)


def eyes_closed(background: Background, share: float = 0.7) -> np.ndarray:
    """Frames (n,) bool in which the eyes are opened less than a ``share`` of what they usually are."""
    points = background.landmarks.astype(np.float64)

    def apart(a: int, b: int) -> np.ndarray:
        return np.linalg.norm(points[:, a] - points[:, b], axis=1)

    heights = apart(37, 41) + apart(38, 40) + apart(43, 47) + apart(44, 46)
    opening = heights / (apart(36, 39) + apart(42, 45))
    return opening < share * np.median(opening)


def _all_distances(rows: np.ndarray) -> np.ndarray:
    rows = rows - rows.mean(axis=0)
    squares = (rows**2).sum(axis=1)
    return np.sqrt(np.maximum(squares[:, None] + squares - 2 * rows @ rows.T, 0) / rows.shape[1])


def _thumbnails(background: Background) -> Iterator[np.ndarray]:
    """Small grey pictures (m,) with the lower face blackened at one place in all frames."""
    import cv2

    width, height = background.size
    small = (_THUMBNAIL, max(1, round(_THUMBNAIL * height / width)))
    hidden = np.zeros((height, width), np.uint8)
    for points in background.landmarks[:: max(1, len(background) // 50)]:
        outline = np.concatenate([points[2:15], points[35:30:-1]])
        cv2.fillConvexPoly(hidden, cv2.convexHull(np.rint(outline).astype(np.int32)), 255)
    seen = cv2.resize(hidden, small, interpolation=cv2.INTER_AREA) == 0
    for frame in range(len(background)):
        grey = cv2.cvtColor(background.picture(frame), cv2.COLOR_RGB2GRAY)
        yield cv2.resize(grey, small, interpolation=cv2.INTER_AREA)[seen]


def describe(background: Background) -> Mapping[str, object]:
    """What a background holds, for people."""
    return {
        "frames": len(background),
        "rate": background.rate,
        "size": list(background.size),
        "media": background.media,
    }
