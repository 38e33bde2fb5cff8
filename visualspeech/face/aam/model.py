"""The active appearance model of the lower face (Cootes 2001; Fan 2015, section 3.2, Eq. 1-8).

Notation of the docstrings: N points, U texture pixels, T frames; s shape vector (2N,) in pixels of the normalised face
(Eq. 1), t texture (3U,) in grey levels (Eq. 4), a shape, b texture and v appearance parameters.

Weighting. Shapes are pixels and textures are grey levels, so the joint analysis of Eq. 6 depends on how the two are
weighted. Here it is done on (w a, b)::

    (w a, b) = v P_v,    P_v orthonormal

With ``weighting="variance"`` w is the square root of texture variance over shape variance (Cootes 2001, section 2.1),
with ``"none"`` w is 1, the paper's equation as printed. Dividing the first columns of P_v by w gives P_vs, and with it
Eq. 7 and 8 hold as they stand: a = v P_vs, b = v P_vt, s = s_0 + v Q_s, t = t_0 + v Q_t.
"""

from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np

from visualspeech.errors import DamagedFile, DataError
from visualspeech.face.aam.empca import Rows, em_pca, pca
from visualspeech.face.aam.model_settings import AamSettings
from visualspeech.face.coding import CodedFaces
from visualspeech.face.drift import FaceReference, Faces, remove, remove_shape
from visualspeech.face.point_sets import PointSet, stored_point_set, to_points
from visualspeech.fields import restored
from visualspeech.jobs import log
from visualspeech.storage.layouts import TEXT, Array, FileLayout
from visualspeech.storage.models import read_model_of, write_model

KIND = "aam"
_CHUNK = 256  # frames encoded at a time


class Parameters(NamedTuple):
    """Parameters of T frames: shape a (T, Ns), texture b (T, Nt), appearance v (T, N), float32; and residual (T,)
    float32, the root mean square in grey levels of what the texture components leave of each texture."""

    shape: np.ndarray
    texture: np.ndarray
    appearance: np.ndarray
    residual: np.ndarray


@dataclass(frozen=True)
class Aam:
    """A trained model; a visual coding of the kind ``aam`` (:mod:`visualspeech.face.coding`).

    Parameters
    ----------
    points : the point set, of N points
    shape_mean : (2N,) s_0; shape_components : (Ns, 2N) P_s, orthonormal; shape_variances : (Ns,)
    texture_mean : (3U,) t_0; texture_components : (Nt, 3U) P_t, orthonormal; texture_variances : (Nt,)
    appearance_components : (N, Ns + Nt) P_v, orthonormal, for (w a, b); appearance_variances : (N,)
    shape_weight : w
    totals : (3,) total variance of the training shapes, textures and (w a, b)
    drift : the corpus's reference face; utterances are moved onto it before encoding (:mod:`visualspeech.face.drift`)
    settings : the settings it was trained with
    """

    points: PointSet
    shape_mean: np.ndarray
    shape_components: np.ndarray
    shape_variances: np.ndarray
    texture_mean: np.ndarray
    texture_components: np.ndarray
    texture_variances: np.ndarray
    appearance_components: np.ndarray
    appearance_variances: np.ndarray
    shape_weight: float
    totals: np.ndarray
    drift: FaceReference
    settings: AamSettings

    @property
    def sizes(self) -> tuple[int, int, int]:
        """Numbers of shape, texture and appearance components (Ns, Nt, N)."""
        return len(self.shape_components), len(self.texture_components), len(self.appearance_components)

    @property
    def size(self) -> int:
        """N, the number of appearance parameters per frame."""
        return len(self.appearance_components)

    @property
    def energies(self) -> tuple[float, float, float]:
        """Fractions of the training variance that shape, texture and appearance components hold."""
        kept = [self.shape_variances.sum(), self.texture_variances.sum(), self.appearance_variances.sum()]
        return tuple(float(x) for x in np.array(kept) / self.totals)

    @cached_property
    def appearance_to_shape(self) -> np.ndarray:
        """P_vs (N, Ns), the weight taken out: a = v P_vs (Eq. 7)."""
        return (self.appearance_components[:, : self.sizes[0]] / self.shape_weight).astype(np.float32)

    @cached_property
    def appearance_to_texture(self) -> np.ndarray:
        """P_vt (N, Nt): b = v P_vt (Eq. 8)."""
        return np.ascontiguousarray(self.appearance_components[:, self.sizes[0] :])

    @cached_property
    def shape_basis(self) -> np.ndarray:
        """Q_s = P_vs P_s (N, 2N) (Eq. 7)."""
        return self.appearance_to_shape @ self.shape_components

    @cached_property
    def texture_basis(self) -> np.ndarray:
        """Q_t = P_vt P_t (N, 3U) (Eq. 8)."""
        return self.appearance_to_texture @ self.texture_components

    def encode(self, shape: np.ndarray, texture: np.ndarray) -> Parameters:
        """Parameters of T faces without drift: shape (T, 2N) and texture (T, 3U), any number types (Eq. 3, 5, 6).

        Raises
        ------
        DataError
            The lengths differ, or the vectors are not those of this model.
        """
        return self._in_chunks(shape, texture, lambda shape, texture: (shape, texture))

    def encode_faces(self, faces: Faces) -> CodedFaces:
        """Code an utterance as recorded: its drift is removed with its own reference face, then it is encoded.

        ``details`` are the shape and texture parameters and the residual (:class:`Parameters`), and ``points``, the
        shape vectors (T, 2N) without drift.

        Raises
        ------
        DataError
            As :meth:`encode`.
        """
        own, corpus = faces.reference, self.drift
        coded = self._in_chunks(faces.shape, faces.texture, lambda *chunk: remove(*chunk, own, corpus))
        details = {"shape": coded.shape, "texture": coded.texture, "residual": coded.residual}
        details["points"] = remove_shape(faces.shape, own, corpus)
        offset = FaceReference(own.shape - corpus.shape, own.texture - corpus.texture)
        return CodedFaces(coded.appearance, offset, details)

    def _in_chunks(self, shape: np.ndarray, texture: np.ndarray, prepare) -> Parameters:
        expected = (len(shape), len(self.shape_mean)), (len(shape), len(self.texture_mean))
        if (shape.shape, texture.shape) != expected:
            raise DataError(
                f"shapes {shape.shape} and textures {texture.shape} do not fit this AAM, expected {expected}"
            )
        parts = []
        for start in range(0, max(len(shape), 1), _CHUNK):
            rows = slice(start, start + _CHUNK)
            parts.append(self._encode(*prepare(shape[rows], texture[rows])))
        return Parameters(*(np.concatenate(values) for values in zip(*parts, strict=True)))

    def _encode(self, shape: np.ndarray, texture: np.ndarray) -> Parameters:
        a = (np.asarray(shape, np.float32) - self.shape_mean) @ self.shape_components.T
        away = np.asarray(texture, np.float32) - self.texture_mean
        b = away @ self.texture_components.T
        left = np.einsum("ij,ij->i", away, away, dtype=np.float64) - np.einsum("ij,ij->i", b, b, dtype=np.float64)
        residual = np.sqrt(np.maximum(left, 0) / away.shape[1]).astype(np.float32)
        v = np.concatenate([a * np.float32(self.shape_weight), b], axis=1) @ self.appearance_components.T
        return Parameters(a, b, v, residual)

    def decode(self, appearance: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Faces of parameters v (T, N): shape (T, 2N) and texture (T, 3U), float32, not clipped (Eq. 7, 8)."""
        v = np.asarray(appearance, np.float32)
        return self.shape_mean + v @ self.shape_basis, self.texture_mean + v @ self.texture_basis

    @property
    def regions(self) -> dict[str, tuple[int, ...]]:
        """No regions: a parameter moves the whole face."""
        return {}

    def decode_points(self, appearance: np.ndarray, speaker: str = "") -> np.ndarray:
        """Points (T, N, 2) of the normalised face for parameters v (T, N) (Eq. 7), without drift."""
        return to_points(self.shape_mean + np.asarray(appearance) @ self.shape_basis)

    def decode_texture(self, appearance: np.ndarray) -> np.ndarray:
        """Textures (T, 3U) for parameters v (T, N) (Eq. 8), float32, without drift and not clipped."""
        return self.texture_mean + np.asarray(appearance, np.float32) @ self.texture_basis

    def shape_parameters(self, appearance: np.ndarray) -> np.ndarray:
        """Shape parameters a (T, Ns) reconstructed from v (T, N): what Eq. 16 compares."""
        return np.asarray(appearance, np.float32) @ self.appearance_to_shape

    def texture_parameters(self, appearance: np.ndarray) -> np.ndarray:
        """Texture parameters b (T, Nt) reconstructed from v (T, N): what Eq. 17 compares."""
        return np.asarray(appearance, np.float32) @ self.appearance_to_texture

    def save(self, path: str | Path) -> None:
        """Write the model as safetensors, with the name of its point set."""
        tensors = {name: np.asarray(getattr(self, name)) for name in _ARRAYS}
        tensors |= {"drift_shape": self.drift.shape, "drift_texture": self.drift.texture}
        sizes = dict(zip(("shape", "texture", "appearance"), self.sizes, strict=True))
        metadata = {"kind": KIND, "points": self.points.name, "sizes": sizes, "settings": asdict(self.settings)}
        write_model(path, tensors, metadata)

    @classmethod
    def load(cls, path: str | Path) -> "Aam":
        """Read what :meth:`save` wrote; raises as :func:`visualspeech.storage.models.read_model_of`."""
        tensors, stored = read_model_of(path, "appearance model", [KIND], LAYOUT)
        points, settings = stored_point_set(stored["points"], path), restored(AamSettings, stored["settings"], path)
        _check_sizes(path, tensors, points)
        drift = FaceReference(tensors.pop("drift_shape"), tensors.pop("drift_texture"))
        weight = tensors.pop("shape_weight").item()
        return cls(points=points, drift=drift, shape_weight=weight, settings=settings, **tensors)


_VARIANCES = {"low": -1.0}  # an eigenvalue that is 0 may be a little below it
_ARRAYS = {
    "shape_mean": Array("f", ("2P",), -1e5, 1e5),
    "shape_components": Array("f", ("S", "2P"), -1.01, 1.01),
    "shape_variances": Array("f", ("S",), **_VARIANCES),
    "texture_mean": Array("f", ("3U",), -1e4, 1e4),
    "texture_components": Array("f", ("T", "3U"), -1.01, 1.01),
    "texture_variances": Array("f", ("T",), **_VARIANCES),
    "appearance_components": Array("f", ("N", "A"), -1.01, 1.01),
    "appearance_variances": Array("f", ("N",), **_VARIANCES),
    "shape_weight": Array("f", (), 1e-6, 1e6),
    "totals": Array("f", (3,), 0.0),
}
_DRIFT = {
    "drift_shape": Array("f", ("2P",), -1e5, 1e5),
    "drift_texture": Array("f", ("3U",), -1e4, 1e4),
}
#: P points, U texture pixels, S shape, T texture and N appearance components, A = S + T.
LAYOUT = FileLayout(_ARRAYS | _DRIFT, {"points": TEXT, "sizes": {"type": "object"}, "settings": {"type": "object"}})


def _check_sizes(path, tensors, points: PointSet) -> None:
    """Refuse sizes that do not fit each other, although each array is right by itself."""
    shape, texture, appearance = (tensors[f"{name}_components"] for name in ("shape", "texture", "appearance"))
    count = shape.shape[1] // 2
    if count != points.size:
        raise DamagedFile(path, f"its shapes have {count} points, the point set {points.name} {points.size}")
    both = len(shape) + len(texture)
    # More components than values would also let a small file stand for arrays that no memory holds.
    if appearance.shape[1] != both or any(len(one) > one.shape[1] for one in (shape, texture, appearance)):
        raise DamagedFile(path, "its numbers of components do not fit each other")


def fit(
    shapes: np.ndarray,
    textures: Rows,
    points: PointSet,
    settings: AamSettings | None = None,
    drift: FaceReference | None = None,
) -> Aam:
    """Train an :class:`Aam` on J faces without drift (Eq. 2, 3, 5, 6).

    Parameters
    ----------
    shapes : (J, 2N)
    textures : source of J rows of 3U values (:class:`~visualspeech.face.aam.rows.RowFile` or ``ArrayRows``)
    points : the point set, of N points
    drift : the corpus's reference face, kept with the model; zeros where there is none

    Raises
    ------
    DataError
        The numbers of shapes and textures differ, the shapes have another number of points, or nothing varies.
    SettingError
        More components, or more energy, than the data can give.
    """
    settings = settings or AamSettings()
    if shapes.shape[1:] != (2 * points.size,):
        raise DataError(f"expected shape vectors of the {points.size} points of {points.name}, got {shapes.shape}")
    if len(shapes) != textures.shape[0]:
        raise DataError(f"{len(shapes)} training shapes but {textures.shape[0]} training textures")
    s = pca(np.asarray(shapes, np.float64), **settings.shape, what="AAM shape")
    t = em_pca(textures, **settings.texture, iterations=settings.iterations, seed=settings.seed, what="AAM texture")
    a = (np.asarray(shapes, np.float32) - s.mean) @ s.components.T
    b = np.concatenate([(chunk - t.mean) @ t.components.T for chunk in textures.chunks()])
    weight = 1.0
    if settings.weighting == "variance":
        weight = float(np.sqrt(t.eigenvalues.sum() / s.eigenvalues.sum()))
    v = pca(np.concatenate([a * weight, b], axis=1).astype(np.float64), **settings.appearance, what="AAM appearance")
    # In the order in which files keep arrays, so that a model gives the same bits before it is saved and after.
    aam = Aam(
        points=points,
        shape_mean=s.mean,
        shape_components=np.ascontiguousarray(s.components),
        shape_variances=s.eigenvalues,
        texture_mean=t.mean,
        texture_components=t.components,
        texture_variances=t.eigenvalues,
        appearance_components=np.ascontiguousarray(v.components),
        appearance_variances=v.eigenvalues,
        shape_weight=weight,
        totals=np.array([s.total_variance, t.total_variance, v.total_variance]),
        drift=drift or FaceReference(np.zeros_like(s.mean), np.zeros_like(t.mean)),
        settings=settings,
    )
    log.info(
        "AAM of %d faces: %d shape components (%.4f of the variance), %d texture (%.4f), %d appearance (%.4f), "
        "shape weight %.4g",
        len(shapes),
        *(value for pair in zip(aam.sizes, aam.energies, strict=True) for value in pair),
        weight,
    )
    return aam
