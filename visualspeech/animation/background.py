"""Background recordings: recorded frames of a speaker onto which a synthetic lower face is stitched.

A background is a few recordings in one HDF5 file. Every frame is a separate JPEG, so that all frames can be read in any
order at the same cost. Landmarks, head pose and the reference face of each recording are stored with them.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from visualspeech.errors import DamagedFile, DataError, SettingError
from visualspeech.face import blinks
from visualspeech.face.blinks import CLOSED
from visualspeech.face.drift import FaceReference
from visualspeech.face.pose import Pose
from visualspeech.face.tracker import POINTS, RIGID
from visualspeech.fields import shortened
from visualspeech.storage.arrays import ArrayReader, ArrayWriter
from visualspeech.storage.layouts import RATE, TEXT, Array, check_arrays, check_plain

UPPER = np.r_[0:3, 14:17, 17:48]
"""Landmarks that do not move with speech but with blinks: temples, brows, nose, eyes."""

QUALITY = 97  # of the JPEGs; their error is smaller than that of the recording's own compression
MAX_FRAMES = 10_000  # of a background: distances between all pairs of its frames are kept in memory
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
    path : of the file, for messages
    names : of the C recordings
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
    path: str = ""
    names: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.jpegs)

    def frame(self, index: int) -> np.ndarray:
        """One frame, (height, width, 3) uint8 RGB.

        Raises
        ------
        StorageError
            It is damaged.
        """
        import cv2

        coded = np.frombuffer(self.jpegs[index], np.uint8)
        # The size is read from the header first: a few bytes could ask for an image that no memory holds.
        decoded = cv2.imdecode(coded, cv2.IMREAD_COLOR) if jpeg_size(self.jpegs[index]) == self.size else None
        if decoded is None or decoded.shape[1::-1] != self.size:
            raise DamagedFile(self.path, f"frame {index + 1} is no JPEG of {self.size[0]} by {self.size[1]} pixels")
        return cv2.cvtColor(decoded, cv2.COLOR_BGR2RGB)

    @cached_property
    def distances(self) -> np.ndarray:
        """:func:`frame_distances`, kept for all that is said on this background."""
        return frame_distances(self)

    @classmethod
    def load(cls, path: str | Path) -> "Background":
        """The background that :func:`write_background` wrote.

        Raises
        ------
        StorageError
            The file is missing, damaged or of another kind.
        """
        with ArrayReader(path) as file:
            names = tuple(file.ids)
            recordings = [(file[name], file.attributes(name)) for name in names]
        if not recordings:
            raise DamagedFile(path, "it holds no recording")
        _check(path, recordings)
        jpegs, clips = [], []
        for number, (arrays, _) in enumerate(recordings):
            borders = np.r_[0, arrays["ends"]]
            coded = arrays["pictures"].tobytes()
            jpegs += [coded[a:b] for a, b in zip(borders[:-1], borders[1:], strict=True)]
            clips += [number] * len(arrays["ends"])

        def joined(name: str) -> np.ndarray:
            return np.concatenate([arrays[name] for arrays, _ in recordings])

        first = recordings[0][1]
        return cls(
            jpegs=tuple(jpegs),
            landmarks=joined("landmarks"),
            pose=Pose(joined("rotation"), joined("translation")),
            clip=np.array(clips),
            shapes=np.stack([arrays["reference_shape"] for arrays, _ in recordings]),
            textures=np.stack([arrays["reference_texture"] for arrays, _ in recordings]),
            media=tuple(attributes["media"] for _, attributes in recordings),
            rate=float(first["rate"]),
            size=(int(first["width"]), int(first["height"])),
            path=str(path),
            names=names,
        )

    def only(self, name: str) -> "Background":
        """The frames of one of its recordings.

        Raises
        ------
        SettingError
            It has no recording of this name.
        """
        if name not in self.names:
            listed = ", ".join(shortened(one, 40) for one in self.names[:20])
            raise SettingError(f"the background has no recording {shortened(name)}; there are {listed}.")
        number = self.names.index(name)
        frames = np.flatnonzero(self.clip == number)
        return replace(
            self,
            jpegs=tuple(self.jpegs[frame] for frame in frames),
            landmarks=self.landmarks[frames],
            pose=self.pose[frames],
            clip=np.zeros(len(frames), int),
            shapes=self.shapes[[number]],
            textures=self.textures[[number]],
            media=(self.media[number],),
            names=(name,),
        )


_PIXELS = {"type": "integer", "minimum": 16, "maximum": 16_384}
_ATTRIBUTES = {
    "type": "object",
    "required": ["rate", "media", "width", "height"],
    "additionalProperties": False,
    "properties": {"rate": {**RATE, "maximum": 1000}, "media": TEXT, "width": _PIXELS, "height": _PIXELS},
}
_ARRAYS = {
    "pictures": Array("u", ("B",)),
    "ends": Array("iu", ("T",), 1),
    "landmarks": Array("f", ("T", POINTS, 2)),
    "rotation": Array("f", ("T", 3), -100, 100),
    "translation": Array("f", ("T", 3), -1e6, 1e6),
    "reference_shape": Array("f", ("2P",), -1e5, 1e5),
    "reference_texture": Array("f", ("3U",), -1e4, 1e4),
}


def _check(path, recordings) -> None:
    """Refuse recordings that do not fit each other, too many frames, and landmarks far outside the frame."""
    frames, sizes = 0, {}
    for arrays, attributes in recordings:
        check_plain(path, attributes, _ATTRIBUTES)
        found = check_arrays(path, arrays, _ARRAYS, sizes)
        sizes = {name: found[name] for name in ("P", "U")}
        frames += found["T"]
        same = all(attributes[name] == recordings[0][1][name] for name in ("rate", "width", "height"))
        if not same or arrays["pictures"].dtype != np.uint8:
            raise DamagedFile(path, "its recordings differ in frame rate or size")
        if (np.diff(arrays["ends"].astype(np.int64), prepend=0) <= 0).any() or arrays["ends"][-1] != found["B"]:
            raise DamagedFile(path, "its frames overlap or are missing")
        size = np.array([attributes["width"], attributes["height"]], np.float64)
        if not (np.abs(arrays["landmarks"] / size - 0.5) < 2).all():
            raise DamagedFile(path, "its landmarks lie far outside the frame")
    if frames > MAX_FRAMES:
        raise DamagedFile(path, f"it has {frames} frames, more than {MAX_FRAMES}")


def jpeg_size(data: bytes) -> tuple[int, int] | None:
    """Width and height in pixels from the header of a JPEG; None if there is none."""
    at = 2
    while data[:2] == b"\xff\xd8" and at + 9 <= len(data) and data[at] == 0xFF:
        marker, length = data[at + 1], int.from_bytes(data[at + 2 : at + 4], "big")
        if 0xC0 <= marker <= 0xCF and marker not in (0xC4, 0xC8, 0xCC):  # start of a frame
            height, width = (int.from_bytes(data[at + i : at + i + 2], "big") for i in (5, 7))
            return width, height
        at += 2 + length
    return None


def write_background(path: str | Path, clips: Iterable[tuple]) -> None:
    """Write a background, one recording at a time.

    Parameters
    ----------
    clips : for each recording (name, path of the media, frames (height, width, 3) uint8 RGB, landmarks (T, 68, 2),
        pose, reference face, frame rate in Hz); frames are taken one at a time

    Raises
    ------
    DataError
        The recordings differ in size or rate or have too many frames, a recording has more or fewer frames than
        landmarks or poses, or there is no recording.
    """
    import cv2

    first, total = None, 0
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
            total += len(coded)
            if total > MAX_FRAMES:
                raise DataError(f"the background has more than {MAX_FRAMES:,} frames; give fewer recordings.")
            if first is None:
                first = size, rate
            if first != (size, rate):
                raise DataError(
                    f"{media} has {size} pixels at {rate:g} Hz, the first background recording {first[0]} at "
                    f"{first[1]:g} Hz; give recordings of one camera."
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

    Recordings with a double blink (:func:`visualspeech.face.blinks.double_blinks`) are taken only where the others do
    not last long enough: played over and over again, a double blink catches the eye.

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
    names, seats, lengths, lights, doubled = [], [], [], [], []
    for name, landmarks, face in faces:
        names.append(name)
        lengths.append(len(landmarks) / rate)
        seats.append(np.median(landmarks[:, RIGID], axis=0).ravel())
        lights.append(face.texture.reshape(3, -1).mean(axis=1) if face.texture.any() else np.zeros(3))
        doubled.append(blinks.double_blinks(landmarks, rate) > 0)
    if not names:
        raise DataError("there is no recording to take the background from: every utterance was rejected.")
    seats, lights = np.array(seats), np.array(lights)
    distance = _distances(seats, np.median(seats, axis=0)) + _distances(lights, np.median(lights, axis=0))
    typical = np.lexsort((distance, doubled))[0]
    # One pixel counts as much as one grey level: both are just visible in a transition.
    apart = _distances(seats, seats[typical]) + _distances(lights, lights[typical])
    chosen, total = [], 0.0
    for number in np.lexsort((apart, doubled)):
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


def eyes_closed(background: Background, share: float = CLOSED) -> np.ndarray:
    """Whether the eyes are closed in each frame, (n,) bool: opened less than ``share`` of the median opening."""
    return blinks.eyes_closed(background.landmarks, share)


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
