"""Building of a speaker bundle (:mod:`visualspeech.animation.bundle`) from the files of a run."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

from visualspeech.animation.background import choose_recordings, write_background
from visualspeech.animation.bundle import DICTIONARY, FILES, describe_bundle
from visualspeech.animation.video import Recording
from visualspeech.corpora.findings import needed
from visualspeech.corpora.records import Utterance
from visualspeech.corpora.table import of_split
from visualspeech.errors import SettingError
from visualspeech.face.drift import reference_face
from visualspeech.jobs import log
from visualspeech.media.reading import read_frames
from visualspeech.models.rest import resting_face
from visualspeech.speech.alignment import alignments_of
from visualspeech.speech.dictionary import read_dictionary
from visualspeech.speech.phone_sets import PhoneSet
from visualspeech.speech.spoken import state_shares
from visualspeech.storage.files import copy_file, replacing, write_text


class RecordedFaces(NamedTuple):
    """Opened files of the utterances: ``ArrayReader`` or ``ArrayCollection``.

    Parameters
    ----------
    landmarks : ``points`` (T, 68, 2) in pixels of the recording
    pose : head pose, with the frame rate
    textures : reference face of each utterance
    parameters : ``appearance`` (T, N), the parameters of the visual coding
    """

    landmarks: object
    pose: object
    textures: object
    parameters: object


def bundle_speaker(
    folder: str | Path,
    files: Mapping[str, str | Path],
    phones: Sequence[str],
    utterances: Sequence[Utterance],
    alignments: Iterable[str | Path],
    faces: RecordedFaces,
    background: Sequence[str] = (),
    *,
    seconds: float,
    corpus: str,
    model: str,
    consent: str,
    sound_model: str = "",
    dictionary: Mapping = MappingProxyType({}),
) -> None:
    """Write a speaker bundle.

    The face at rest and the average shares of the phones' states are taken from the training utterances.

    Parameters
    ----------
    folder : of the bundle; an existing one is replaced as a whole
    files : paths of the parts ``model``, ``aam``, ``reference``, ``head`` and, if there is one, ``sound``, which are
        copied
    phones : inventory of the corpus
    utterances : the accepted utterances, with their split
    alignments : paths of the alignment tables of these utterances
    background : ids of the background recordings; empty: training utterances with similar head position and light
    seconds : minimum duration of the background if ``background`` is empty
    corpus, model, consent : for the metadata of videos
    sound_model : name of the model in the part ``sound``; empty if there is none
    dictionary : ``path`` and phone set (``phones``, plain data) of the run's pronunciation dictionary; empty for none

    Raises
    ------
    SettingError
        A background recording is not an accepted utterance.
    DataError
        There is no training utterance, none of them shows the face at rest, or the parts do not fit each other.
    CorpusError
        A recording of the background cannot be read.
    StorageError
        A file is missing, or the folder cannot be written.
    """
    training = of_split(utterances, "train")
    shown = _background(utterances, training, faces, background, seconds)
    log.info("background: %s", ", ".join(one.id for one in shown))
    with replacing(folder) as made:
        made.mkdir()
        for name, path in files.items():
            copy_file(path, made / FILES[name])
        if dictionary:
            own = read_dictionary(dictionary["path"], PhoneSet(**dictionary["phones"]))
            write_text(made / FILES[DICTIONARY], own.text())
        write_background(made / FILES["background"], _clips(shown, faces))
        aligned = alignments_of(alignments, [one.id for one in training])
        arrays = faces.parameters
        rest = resting_face(
            lambda: ((found, arrays.array(name, "appearance"), arrays.rate(name)) for name, found in aligned.items())
        )
        shares = state_shares(aligned.values())
        describe_bundle(made, phones, shares, rest, corpus, model, consent, sound_model)


def _background(
    utterances: Sequence[Utterance],
    training: Sequence[Utterance],
    faces: RecordedFaces,
    names: Sequence[str],
    seconds: float,
) -> list[Utterance]:
    """The named utterances, or by default training utterances with similar head position and light."""
    known = {one.id: one for one in utterances}
    missing = [name for name in names if name not in known]
    if missing:
        raise SettingError(
            f"`speak.background`: {', '.join(missing)} is no accepted utterance. Name other recordings, or none to "
            "have them chosen automatically."
        )
    if not names and training:
        rate = faces.pose.rate(training[0].id)
        seen = (
            (one.id, faces.landmarks.array(one.id, "points"), reference_face(faces.textures, one.id))
            for one in training
        )
        names = choose_recordings(seen, seconds, rate)
    return [known[name] for name in names]


def _clips(utterances: Iterable[Utterance], faces: RecordedFaces) -> Iterator[tuple]:
    """Recordings as :func:`visualspeech.animation.background.write_background` takes them."""
    for one in utterances:
        seen = Recording.read(faces.landmarks, faces.pose, faces.textures, one.id)
        rate = faces.pose.rate(one.id)
        yield one.id, one.media, _frames(one), seen.landmarks, seen.pose, seen.drift, rate


def _frames(utterance: Utterance) -> Iterator:
    with needed(utterance):
        yield from read_frames(utterance.media, utterance.start, utterance.end)
