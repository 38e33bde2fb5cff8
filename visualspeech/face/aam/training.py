"""Training of an AAM on the files of training utterances."""

from collections.abc import Sequence

import numpy as np

from visualspeech.errors import DataError
from visualspeech.face.aam.model import Aam, AamSettings, fit
from visualspeech.face.aam.rows import RowFile, choose_frames
from visualspeech.face.drift import corpus_reference, reference_face, remove
from visualspeech.face.point_sets import PointSet
from visualspeech.jobs import progress

_CHUNK = 256  # frames read at a time


def fit_aam(
    arrays,
    ids: Sequence[str],
    points: PointSet,
    settings: AamSettings | None = None,
    folder: str | None = None,
) -> Aam:
    """Train an :class:`~visualspeech.face.aam.model.Aam` on frames drawn from training utterances, drift removed.

    Memory does not grow with the number of utterances: the textures drawn are kept in a scratch file (4 bytes per
    value, 1.4 GB for 20,000 x 18,000), which the system deletes at the end.

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
    textures = RowFile(folder, len(corpus.texture))
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
