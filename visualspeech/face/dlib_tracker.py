"""The default tracker: dlib's 68-point regression trees on a crop that follows the face.

Three measures make it more stable and faster than detection and prediction in every frame:

- the box is a low-pass-filtered function of the previous frame's rigid points, so that the points do not depend on the
  coarse steps of the detector's image pyramid, neither from frame to frame nor from recording to recording;
- the crop is cut at sub-pixel position, brought upright and to a fixed size (dlib's points are whole pixels);
- the detector runs at intervals on the whole frame; in between only on a small crop, and only when the content of the
  box no longer resembles the face that was confirmed last.
"""

import functools

import numpy as np

from visualspeech.face.tracker import RIGID, LandmarkSettings, TrackedVideo

# The box in units of the RMS radius of the rigid points: its side, and how far its centre lies below theirs. The
# detector draws it at 5.39 and 0.40 on GRID's s1 on average; a little smaller and lower, the points jitter less
# there and lie closer to the truth of the demo corpus (lips 0.88 -> 0.74 px).
BOX_SIDE = 5.0
BOX_BELOW = 0.70
# The crop shows this many box sides: the regression looks at pixels outside the box (chin, ears).
CROP_SIDES = 1.3
# Share of the distance that the box moves towards the face in each frame.
FOLLOW = 0.5
# The detector's window is 80 pixels; a face is easiest to confirm slightly above that.
CONFIRM_PIXELS = 92
CONFIRM_SIDES = 1.7
# Side length, in pixels, of the thumbnails by which the face is recognised.
THUMBNAIL_PIXELS = 32


@functools.cache
def _models():
    import importlib.util
    from pathlib import Path

    import dlib

    package = importlib.util.find_spec("face_recognition_models")
    folder = Path(package.origin).parent / "models"
    return dlib.get_frontal_face_detector(), dlib.shape_predictor(str(folder / "shape_predictor_68_face_landmarks.dat"))


class DlibTracker:
    """Follows the face of one recording; see :class:`visualspeech.face.tracker.Tracker`."""

    def __init__(self, settings: LandmarkSettings, video: TrackedVideo) -> None:
        import cv2

        self._cv = cv2
        self._settings = settings
        self._search_every = max(round(settings.detection_interval * video.rate), 1)  # frames
        self._detector, self._predictor = _models()
        self._box = None  # centre x, centre y, side, roll (radians)
        self._confirmed = None  # small image of the face that was confirmed last
        self._frame = 0
        self._faces = 0

    def faces(self) -> int:
        return self._faces

    def next(self, frame: np.ndarray, number: int) -> np.ndarray | None:
        grey = self._cv.cvtColor(frame, self._cv.COLOR_RGB2GRAY)
        self._frame += 1
        known = self._box is not None and not self._due()
        crop = self._face(grey) if known else None
        if not known or not (self._similar(crop) or self._confirm(grey)):
            found = self._search(grey)
            if found is None and not (self._box is not None and self._confirm(grey)):
                self._confirmed = None
                return None
            if found is not None and self._moved(found):
                self._box = found
                # The detector's box only initialises the points; the box is then computed from them.
                self._box = box_of(self._predict(*self._face(grey)))
            self._confirmed = None
            crop = self._face(grey)
        if self._confirmed is None:
            self._confirmed = _thumbnail(crop[0])
        points = self._predict(*crop)
        for number in range(1, self._settings.num_jitters):
            points = points + self._predict(*self._face(grey, _shaken(self._box, number)))
        points = points / max(self._settings.num_jitters, 1)
        self._box = self._box + FOLLOW * (box_of(points) - self._box)
        return points

    def _due(self) -> bool:
        """Whether the detector runs on this whole frame."""
        return (self._frame - 1) % self._search_every == 0

    def _face(self, grey: np.ndarray, box: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        """The crop from which points are predicted, and the map into it."""
        return self._crop(grey, self._box if box is None else box, self._settings.face_pixels, CROP_SIDES)

    def _crop(self, grey: np.ndarray, box: np.ndarray, face: float, sides: float) -> tuple[np.ndarray, np.ndarray]:
        """An upright square around the box in which the face is ``face`` pixels wide, and the (2, 3) map into it."""
        scale = face / box[2]
        cosine, sine = np.cos(box[3]) * scale, np.sin(box[3]) * scale
        size = int(round(face * sides))
        turn = np.array([[cosine, sine], [-sine, cosine]])
        matrix = np.column_stack([turn, size / 2 - turn @ box[:2]])
        if scale < 0.6:  # bilinear sampling would alias
            shrink = scale / 0.8
            grey = self._cv.resize(grey, None, fx=shrink, fy=shrink, interpolation=self._cv.INTER_AREA)
            half = 0.5 - 0.5 / shrink
            inner = np.column_stack([turn / shrink, matrix[:, 2] - turn @ (half, half)])
        else:
            inner = matrix
        crop = self._cv.warpAffine(
            grey, inner, (size, size), flags=self._cv.INTER_LINEAR, borderMode=self._cv.BORDER_REPLICATE
        )
        return crop, matrix

    def _predict(self, crop: np.ndarray, matrix: np.ndarray) -> np.ndarray:
        import dlib

        face = self._settings.face_pixels
        low = (crop.shape[0] - face) // 2
        shape = self._predictor(crop, dlib.rectangle(low, low, low + face, low + face))
        points = np.array([(part.x, part.y) for part in shape.parts()], float)
        return np.linalg.solve(matrix[:, :2], (points - matrix[:, 2]).T).T

    def _similar(self, crop: tuple[np.ndarray, np.ndarray]) -> bool:
        if self._confirmed is None:
            return False
        return float((_thumbnail(crop[0]) * self._confirmed).mean()) >= self._settings.similarity_threshold

    def _confirm(self, grey: np.ndarray) -> bool:
        crop = self._crop(grey, self._box, CONFIRM_PIXELS, CONFIRM_SIDES)[0]
        return len(self._detector.run(crop, 0, -0.2)[0]) > 0

    def _search(self, grey: np.ndarray) -> np.ndarray | None:
        """The box of the face in the whole frame: the face followed so far, else the largest confident detection."""
        scale = min(1.0, self._settings.detector_pixels / max(grey.shape))
        image = grey
        if scale < 1.0:
            image = self._cv.resize(grey, None, fx=scale, fy=scale, interpolation=self._cv.INTER_AREA)
        rectangles, scores, _ = self._detector.run(image, 0, 0.0)
        # The detector finds faces at least 80 pixels wide. As long as no face is known, it also searches, at intervals,
        # for faces half as wide, which takes four times as long.
        if not rectangles and self._box is None and self._due():
            rectangles, scores, _ = self._detector.run(image, 1, 0.0)
        if not rectangles:
            return None
        boxes = np.array([((r.left() + r.right()) / 2, (r.top() + r.bottom()) / 2, r.width(), 0) for r in rectangles])
        boxes[:, :3] /= scale
        scores = np.array(scores)
        sure = scores >= 0.3 * scores.max()
        self._faces = max(self._faces, int(sure.sum()))
        if self._box is not None:
            near = np.linalg.norm(boxes[:, :2] - self._box[:2], axis=1)
            if near.min() < 0.5 * self._box[2]:
                return boxes[near.argmin()]
        return boxes[np.where(sure, boxes[:, 2], 0).argmax()]

    def _moved(self, found: np.ndarray) -> bool:
        """Whether the detected face is not in the current box, which is otherwise kept because it is more precise."""
        if self._box is None:
            return True
        far = np.linalg.norm(found[:2] - self._box[:2]) > 0.25 * self._box[2]
        return bool(far or abs(np.log(found[2] / self._box[2])) > 0.3)


def box_of(points: np.ndarray) -> np.ndarray:
    """The box of a face (centre x, centre y, side, roll) from its points (68, 2)."""
    rigid = points[RIGID]
    centre = rigid.mean(0)
    radius = np.sqrt(((rigid - centre) ** 2).sum(1).mean())
    eyes = points[45] - points[36]
    roll = np.arctan2(eyes[1], eyes[0])
    down = np.array([-np.sin(roll), np.cos(roll)])
    return np.array([*(centre + BOX_BELOW * radius * down), BOX_SIDE * radius, roll])


def _thumbnail(crop: np.ndarray) -> np.ndarray:
    """A coarse sample of the crop's pixels, normalised to mean 0 and standard deviation 1."""
    step = max(len(crop) // THUMBNAIL_PIXELS, 1)
    sample = crop[step // 2 :: step, step // 2 :: step].astype(float)
    return (sample - sample.mean()) / max(sample.std(), 1e-6)


def _shaken(box: np.ndarray, number: int) -> np.ndarray:
    """A slightly displaced box; the same for the same ``number``."""
    angle = 2.4 * number
    return box + box[2] * 0.02 * np.array([np.cos(angle), np.sin(angle), np.cos(2 * angle), 0])
