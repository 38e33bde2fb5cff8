"""The steps of a visual coding over whole utterances: texture grid, sampling of faces, training of the AAM."""

import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from visualspeech.errors import DataError
from visualspeech.face.aam.model import Aam, AamSettings, fit
from visualspeech.face.aam.reference import Reference, ReferenceSettings, fit_reference, sample_textures
from visualspeech.face.aam.rows import RowFile, choose_frames
from visualspeech.face.drift import DriftSettings, Faces, corpus_reference, reference_face, remove
from visualspeech.face.point_sets import PointSet, to_vector
from visualspeech.jobs import progress

_CHUNK = 256  # frames read at a time


def fit_reference_of(
    pose, ids: Iterable[str], points: PointSet, settings: ReferenceSettings | None = None
) -> Reference:
    """The mean shape and texture grid of training utterances; raises as :func:`fit_reference`.

    Parameters
    ----------
    pose : opened files with ``points`` (T, 68, 2) of each utterance, landmarks in pixels of the normalised face
    ids : the training utterances
    points : the point set of the grid
    """
    return fit_reference((points.select(pose.array(name, "points")) for name in ids), points, settings)


def sample_faces(
    frames: Iterable[np.ndarray],
    landmarks: np.ndarray,
    frontal: np.ndarray,
    reference: Reference,
    silent: np.ndarray | None = None,
    drift: DriftSettings | None = None,
) -> Faces:
    """The faces of one utterance at the tracker's points: shapes, textures and the utterance's reference face.

    Parameters
    ----------
    frames : T frames of the recording in order, (height, width, 3) uint8 RGB
    landmarks : (T, 68, 2) in these frames, pixels
    frontal : (T, 68, 2) the same landmarks in the normalised face, pixels
    silent : (T,) bool, the frames in which nobody speaks; only the drift method ``silence`` needs it

    Raises
    ------
    DataError
        The numbers of frames, landmarks and silent frames differ.
    """
    texture = sample_textures(frames, reference.points.select(landmarks), reference)
    return Faces.of(to_vector(reference.points.select(frontal)), texture, silent, drift)


def fit_aam(
    arrays,
    ids: Sequence[str],
    points: PointSet,
    settings: AamSettings | None = None,
    folder: str | None = None,
) -> Aam:
    """Train an :class:`~visualspeech.face.aam.model.Aam` on frames drawn from training utterances, drift removed.

    Memory does not grow with the number of utterances: the textures drawn are kept in a scratch file (4 bytes per
    value, 1.4 GB for 20,000 x 18,000), which is removed in the end.

    Parameters
    ----------
    arrays : opened files (``ArrayReader`` or ``ArrayCollection``) with the arrays of each utterance's
        :class:`~visualspeech.face.drift.Faces`
    ids : the training utterances
    points : the point set of these faces
    folder : folder of the scratch file; None for the system's

    Raises
    ------
    DataError, SettingError
        As :func:`visualspeech.face.aam.model.fit`.
    StorageError
        The scratch file does not fit on the disk.
    """
    settings = settings or AamSettings()
    ids = sorted(ids)
    chosen = choose_frames({name: arrays.length(name, "shape") for name in ids}, settings.images, settings.seed)
    if not chosen:
        raise DataError("no training frames: every training utterance was rejected or is empty")
    settings.check_possible(sum(map(len, chosen.values())), points.freedom)
    corpus = corpus_reference(reference_face(arrays, name) for name in ids)
    with tempfile.TemporaryDirectory(prefix="visualspeech-aam-", dir=folder) as scratch:
        textures = RowFile(Path(scratch) / "textures.f32", len(corpus.texture))
        shapes = []
        for name, frames in progress(chosen.items(), len(chosen), "utterances read"):
            own = reference_face(arrays, name)
            for start in range(0, int(frames[-1]) + 1, _CHUNK):
                inside = frames[(frames >= start) & (frames < start + _CHUNK)] - start
                rows = slice(start, start + _CHUNK)
                shape = arrays.array(name, "shape", rows)[inside]
                texture = arrays.array(name, "texture", rows)[inside]
                shape, texture = remove(shape, texture, own, corpus)
                shapes.append(shape)
                textures.append(texture)
        return fit(np.concatenate(shapes), textures, points, settings, corpus)
