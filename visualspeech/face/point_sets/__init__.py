"""Point sets: which points of the face a visual coding models, and the mesh that joins them.

A point set is data: one YAML file beside this module per set. Its points are landmarks of the 68-point iBUG scheme or
means of landmarks, so that a linear map selects them from tracked faces. What else depends on the number and order of
the points (mesh, named regions, what follows the jaw, what is painted) is in the file as well; no other module knows
how many points there are.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path

import numpy as np

from visualspeech.errors import DamagedFile, DataError, SettingError
from visualspeech.face.mean_face import MEAN_FACE
from visualspeech.storage.files import read_text

LANDMARKS = 68
REGIONS = ("lips", "outer_lips", "inner_lips")
"""Regions that every set must name: the texture grid, rendering and the measures read them."""


@dataclass(frozen=True, eq=False, repr=False)
class PointSet:
    """The points of a visual coding and their mesh.

    Parameters
    ----------
    name : name of the set, kept in the files of models
    selection : (N, 68) linear map from the landmarks to the points; each row sums to 1
    triangles : (M, 3) int32 points at the corners of each triangle, all in the same turn (clockwise on the screen,
        where y points down)
    regions : name -> indices of points; ``outer_lips`` and ``inner_lips`` in order around the mouth
    mouth_corners : right and left corner of the inner mouth
    mouth_middle : middle of the upper and of the lower inner lip
    lowered : (N,) how far each point follows the jaw when the mouth of the texture grid is opened, 0 to 1
    outline : points around the mesh, in order
    follows : (N,) how far each point of a rendered face follows the target, 0 (stays where it was recorded) to 1
    controls : points that control the warp of the recorded frame around the rendered face
    held : landmarks that control this warp as well, held where they were recorded, for the set does not model them
    slow : points whose target is smoothed in time before rendering
    painted : points around the area that is painted, in order
    face_width : the two ends of the face's width; N + i stands for the i-th held landmark
    """

    name: str
    selection: np.ndarray
    triangles: np.ndarray
    regions: Mapping[str, np.ndarray]
    mouth_corners: tuple[int, int]
    mouth_middle: tuple[int, int]
    lowered: np.ndarray
    outline: np.ndarray
    follows: np.ndarray
    controls: np.ndarray
    held: np.ndarray
    slow: np.ndarray
    painted: np.ndarray
    face_width: tuple[int, int]

    def __post_init__(self) -> None:
        complaint = next(_complaints(self), None)
        if complaint:
            raise DataError(f"point set {self.name}: {complaint}")

    @property
    def size(self) -> int:
        """N, the number of points."""
        return len(self.selection)

    @cached_property
    def free(self) -> np.ndarray:
        """Indices (K,) of the points that move by themselves; each of the others is a mean of these."""
        single = np.count_nonzero(self.selection, axis=1) == 1
        covered = np.any(self.selection[single] > 0, axis=0)
        return np.nonzero(single | np.any(self.selection[:, ~covered] > 0, axis=1))[0]

    @cached_property
    def completion(self) -> np.ndarray:
        """The linear map (N, K) from the free points to all points."""
        single = [number for number in self.free if np.count_nonzero(self.selection[number]) == 1]
        at = {int(np.argmax(self.selection[number])): int(np.searchsorted(self.free, number)) for number in single}
        completion = np.zeros((self.size, len(self.free)))
        completion[self.free, np.arange(len(self.free))] = 1
        for number in np.setdiff1d(np.arange(self.size), self.free):
            for landmark in np.nonzero(self.selection[number])[0]:
                completion[number, at[int(landmark)]] = self.selection[number, landmark]
        return completion

    @property
    def freedom(self) -> int:
        """The number of coordinates that can vary independently: the most components that shapes can have."""
        return 2 * len(self.free)

    @cached_property
    def warp_selection(self) -> np.ndarray:
        """The linear map (N + H, 68) from the landmarks to the points and, after them, the H held landmarks."""
        return np.concatenate([self.selection, np.eye(LANDMARKS)[self.held]])

    @cached_property
    def warp_controls(self) -> np.ndarray:
        """Indices of the controls of the warp among the points and held landmarks."""
        return np.concatenate([self.controls, self.size + np.arange(len(self.held))])

    @cached_property
    def drawing_order(self) -> np.ndarray:
        """The order (M,) in which triangles are drawn: the inside of the mouth, skin, lips."""
        lips = np.isin(self.triangles, self.regions["lips"]).all(axis=1)
        mouth = np.isin(self.triangles, self.regions["inner_lips"]).all(axis=1)
        return np.concatenate([np.nonzero(mouth)[0], np.nonzero(~lips)[0], np.nonzero(lips & ~mouth)[0]])

    def select(self, landmarks: np.ndarray) -> np.ndarray:
        """The points of tracked faces, (..., 68, 2) -> (..., N, 2), in the units of the input.

        Linear, so it works alike on image points and on pose-normalised points, and commutes with every affine map.

        Raises
        ------
        DataError
            The input does not end in (68, 2).
        """
        return _selected(self.selection, landmarks)

    def select_for_warp(self, landmarks: np.ndarray) -> np.ndarray:
        """The points and held landmarks of tracked faces, (..., 68, 2) -> (..., N + H, 2); raises as :meth:`select`."""
        return _selected(self.warp_selection, landmarks)

    def region(self, points: np.ndarray, name: str) -> np.ndarray:
        """Of points (..., N, 2) those of a region, (..., n, 2).

        Raises
        ------
        DataError
            The set has no such region, or the points are not those of this set.
        """
        if name not in self.regions:
            raise DataError(f"point set {self.name} has no region {name!r}; it has {', '.join(sorted(self.regions))}.")
        if points.shape[-2] != self.size:
            expected = f"the {self.size} points of {self.name}, shape (..., {self.size}, 2)"
            raise DataError(f"expected {expected}, got {points.shape}")
        return np.take(points, self.regions[name], axis=-2)

    def areas(self, points: np.ndarray) -> np.ndarray:
        """Signed areas (M,) of the triangles of a face (N, 2), positive where a triangle has its proper turn."""
        a, b, c = np.moveaxis(points[self.triangles], 1, 0)
        ab, ac = b - a, c - a
        return (ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]) / 2

    def open_mouth(self, points: np.ndarray, opening: float) -> np.ndarray:
        """A face (N, 2) with its chin lowered until the inner mouth is at least ``opening`` of its width high."""
        (right, left), (upper, lower) = self.mouth_corners, self.mouth_middle
        width = np.linalg.norm(points[left] - points[right])
        down = max(0.0, opening * width - (points[lower, 1] - points[upper, 1]))
        return points + np.stack([np.zeros(self.size), self.lowered * down], axis=1)


def point_set_names() -> list[str]:
    """Names of all point sets."""
    return sorted(file.stem for file in Path(__file__).parent.glob("*.yaml"))


def point_set_path(name: str) -> Path:
    """The file of a point set.

    Raises
    ------
    SettingError
        There is no point set of that name.
    """
    path = Path(__file__).parent / f"{name}.yaml"
    if not path.is_file():
        raise SettingError(f"there is no point set {name!r}; give one of {', '.join(point_set_names())}.")
    return path


def read_point_set(name: str) -> PointSet:
    """The point set of that name.

    Raises
    ------
    SettingError
        There is no point set of that name.
    DataError
        Its file is damaged; the message says where.
    """
    return _read(point_set_path(name))


def stored_point_set(name: str, path) -> PointSet:
    """The point set that the model file ``path`` names.

    Raises
    ------
    DamagedFile
        There is no point set of that name in this version of the library.
    """
    try:
        return read_point_set(name)
    except (SettingError, DataError) as error:
        raise DamagedFile(path, f"its point set {name[:40]!r} cannot be read ({error})") from error


@lru_cache
def _read(path: Path) -> PointSet:
    return parse_point_set(read_text(path), path.stem)


def parse_point_set(text: str, name: str) -> PointSet:
    """A point set from the text of its YAML file; ``lower_face_51.yaml`` explains the keys.

    Raises
    ------
    DataError
        A key is missing or unknown, or a value is not what it must be.
    """
    import yaml

    try:
        data = yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise DataError(f"point set {name}: not a YAML file ({error})") from error
    try:
        parents = [np.atleast_1d(_indices(one)) for one in data.pop("points")]
        count, mouth, rendering = len(parents), data.pop("mouth"), data.pop("rendering")
        found = PointSet(
            name=name,
            selection=_selection(parents, name),
            triangles=np.array(_indices(data.pop("triangles")), np.int32),
            regions={region: _indices(members) for region, members in data.pop("regions").items()},
            mouth_corners=tuple(mouth.pop("corners")),
            mouth_middle=tuple(mouth.pop("middle")),
            lowered=_shares(data.pop("lowered"), count, 0.0),
            outline=_indices(data.pop("outline")),
            follows=_shares(rendering.pop("follows"), count, 1.0),
            controls=_indices(rendering.pop("controls")),
            held=_indices(rendering.pop("held")),
            slow=_indices(rendering.pop("slow")),
            painted=_indices(rendering.pop("painted")),
            face_width=tuple(rendering.pop("face_width")),
        )
        unknown = [*data, *mouth, *rendering]
    except (KeyError, TypeError, ValueError, AttributeError, IndexError) as error:
        raise DataError(f"point set {name}: a key is missing or has a value of another form ({error!r})") from error
    if unknown:
        raise DataError(f"point set {name}: unknown keys {', '.join(map(str, unknown))}")
    return found


def _indices(values) -> np.ndarray:
    values = np.array(values) if np.size(values) else np.zeros(0, int)
    if values.dtype.kind != "i":
        raise ValueError(f"expected whole numbers, got {values.tolist()}")
    return values


def _selection(parents: list[np.ndarray], name: str) -> np.ndarray:
    weights = np.zeros((len(parents), LANDMARKS))
    for row, landmarks in enumerate(parents):
        if not (len(landmarks) and landmarks.min() >= 0 and landmarks.max() < LANDMARKS):
            raise DataError(
                f"point set {name}: point {row} is no landmark from 0 to {LANDMARKS - 1}, nor a mean of them"
            )
        weights[row, landmarks] = 1 / len(landmarks)
    return weights


def _shares(given: Mapping[int, float], count: int, default: float) -> np.ndarray:
    shares = np.full(count, default)
    for number, share in given.items():
        if not 0 <= number < count:
            raise IndexError(f"there is no point {number}")
        shares[number] = share
    return shares


def _complaints(given: PointSet) -> Iterator[str]:
    """What is wrong with a point set, the first thing first: later checks rely on earlier ones."""
    count = given.size
    if given.selection.shape != (count, LANDMARKS) or not np.allclose(given.selection.sum(axis=1), 1):
        yield f"each row of the selection (N, {LANDMARKS}) must sum to 1; a landmark may occur once in a mean"
    for region in REGIONS:
        if region not in given.regions:
            yield f"it names no region {region}"
    if given.triangles.ndim != 2 or given.triangles.shape[1] != 3:
        yield f"triangles must be (M, 3), not {given.triangles.shape}"
    indices = {"triangles": given.triangles, **given.regions}
    indices |= {key: getattr(given, key) for key in ("outline", "controls", "slow", "painted")}
    indices |= {"mouth.corners": given.mouth_corners, "mouth.middle": given.mouth_middle}
    limits = dict.fromkeys(indices, count) | {"face_width": count + len(given.held), "held": LANDMARKS}
    for key, limit in limits.items():
        values = np.asarray(indices.get(key, getattr(given, key, None)))
        if values.size and not (values.dtype.kind == "i" and values.min() >= 0 and values.max() < limit):
            yield f"{key} has an index outside 0 to {limit - 1}"
    for key in ("mouth_corners", "mouth_middle", "face_width"):
        if len(getattr(given, key)) != 2:
            yield f"{key} must be two points"
    for key in ("lowered", "follows"):
        values = getattr(given, key)
        if values.shape != (count,) or values.min() < 0 or values.max() > 1:
            yield f"{key} must be a share from 0 to 1 per point"
    if not np.isin([*given.regions["outer_lips"], *given.regions["inner_lips"]], given.regions["lips"]).all():
        yield "outer_lips and inner_lips must be points of lips"
    missing = np.setdiff1d(np.arange(count), given.triangles)
    if len(missing):
        yield f"points {missing.tolist()} are in no triangle"
    face = given.open_mouth(given.select(MEAN_FACE[:, :2]), 0.2)
    turned = np.nonzero(given.areas(face) <= 0)[0]
    if len(turned):
        corners = given.triangles[turned[0]].tolist()
        yield f"{len(turned)} triangles have another turn than clockwise on the screen, the first {corners}"


def _selected(selection: np.ndarray, landmarks: np.ndarray) -> np.ndarray:
    landmarks = np.asarray(landmarks)
    if landmarks.shape[-2:] != (LANDMARKS, 2):
        raise DataError(f"expected 68 points with x and y, shape (..., 68, 2), got {landmarks.shape}")
    return (selection.astype(landmarks.dtype) @ landmarks).astype(landmarks.dtype)


def to_vector(points: np.ndarray) -> np.ndarray:
    """Points (..., N, 2) as shape vectors (x_1, ..., x_N, y_1, ..., y_N) (Fan 2015, Eq. 1), (..., 2N)."""
    points = np.asarray(points)
    return np.concatenate([points[..., 0], points[..., 1]], axis=-1)


def to_points(shape: np.ndarray) -> np.ndarray:
    """The inverse of :func:`to_vector`: (..., 2N) -> (..., N, 2)."""
    shape = np.asarray(shape)
    half = shape.shape[-1] // 2
    return np.stack([shape[..., :half], shape[..., half:]], axis=-1)
