"""A voice-ready speaker: everything that speaking needs in one folder, which says what belongs together by digests.

``speaker.json`` names the parts with the digest of each file, the phones, the average shares of their states, and whose
face it is. The parts are ``network.safetensors``, ``aam.safetensors``, ``reference.safetensors``, ``head.safetensors``,
``rest.safetensors`` (the face at rest) and ``background.h5``. The folder can be moved and given away; it refers to
nothing outside.
"""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from visualspeech.animation.background import Background
from visualspeech.animation.video import Speaker
from visualspeech.errors import DataError, StorageError
from visualspeech.face.aam.model import Aam
from visualspeech.face.aam.reference import Reference
from visualspeech.face.head import HeadModel
from visualspeech.models.network import Network
from visualspeech.provenance import file_digest
from visualspeech.speech.alignment import Alignment
from visualspeech.speech.phones import SILENCE
from visualspeech.storage import read_model_of, read_text, write_model, write_text
from visualspeech.timing import frame_times

KIND = "visualspeech speaker"
VERSION = 1
DESCRIPTION = "speaker.json"
PARTS = ("network", "aam", "reference", "head", "rest", "background")
FILES = {name: f"{name}.safetensors" for name in PARTS} | {"background": "background.h5"}
_SHORT_SILENCE = {"after": 0.12, "before": 0.12}  # seconds to speech in recordings without a long silence


@dataclass(frozen=True)
class SpeakerBundle:
    """A speaker who can be made to say any text.

    Parameters
    ----------
    network : from labels to appearance
    speaker : head, appearance model, texture grid
    background : recorded pictures to put the lower face on
    rest : (N,) appearance of the face in silence
    shares : of a phone, the shares of its time that its three states take
    corpus, model, consent : for what a video says of itself
    digest : of the whole bundle
    """

    network: Network
    speaker: Speaker
    background: Background
    rest: np.ndarray
    shares: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    corpus: str = ""
    model: str = ""
    consent: str = ""
    digest: str = ""

    @classmethod
    def load(cls, folder: str | Path) -> "SpeakerBundle":
        """Read a bundle and check that its parts belong together.

        Raises
        ------
        StorageError
            It is no bundle, or a part is missing.
        DataError
            A part is not the one that the bundle was made of, or the parts do not fit each other.
        """
        folder = Path(folder)
        about = _description(folder)
        for name in PARTS:
            path, expected = folder / FILES[name], about["parts"].get(name)
            if not path.is_file():
                raise StorageError(f"the speaker {folder} lacks {path.name}. Copy the whole folder, or make it anew.")
            if file_digest(path) != expected:
                raise DataError(
                    f"{path} is not the file that this speaker was made of (digest {file_digest(path)}, not "
                    f"{expected}): the parts of two speakers were mixed, or the file was changed. Make it anew."
                )
        network = Network.load(folder / FILES["network"])
        speaker = Speaker.load(*(folder / FILES[name] for name in ("head", "aam", "reference")))
        check_together(network, speaker, about["parts"]["aam"], about["phones"])
        rest = read_model_of(folder / FILES["rest"], "face at rest", ["rest"], ["appearance"])[0]["appearance"]
        if rest.shape != (network.outputs,):
            raise DataError(f"{folder / FILES['rest']} is a face of another appearance model. Make the speaker anew.")
        background, aam = Background.load(folder / FILES["background"]), speaker.aam
        sizes = background.shapes.shape[1], background.textures.shape[1]
        if sizes != (len(aam.shape_mean), len(aam.texture_mean)):
            raise DataError(f"{folder / FILES['background']} is of another appearance model. Make the speaker anew.")
        return cls(
            network=network,
            speaker=speaker,
            background=background,
            rest=rest,
            shares={phone: tuple(values) for phone, values in about["state_shares"].items()},
            corpus=about["corpus"],
            model=about["model"],
            consent=about["consent"],
            digest=file_digest(folder / DESCRIPTION),
        )


def check_together(network: Network, speaker: Speaker, aam_digest: str, phones) -> None:
    """Whether a network was trained for an appearance model and for an inventory of phones, before any long work.

    Raises
    ------
    DataError
        It was not.
    """
    sizes, aam = len(speaker.aam.appearance_components), speaker.aam
    if network.outputs != sizes or (network.aam and network.aam != aam_digest):
        raise DataError(
            f"the network was trained for another appearance model (digest {network.aam or 'not known'}, "
            f"{network.outputs} components) than the one given (digest {aam_digest}, {sizes} components); give the "
            "aam/model.safetensors of the network's own run, or train the network anew."
        )
    if list(network.phones) != list(phones):
        differ = sorted(set(network.phones) ^ set(phones))
        shown = f"{', '.join(differ[:6])} in one of them alone" if differ else "in another order"
        raise DataError(
            f"the network was trained for other phones ({len(network.phones)}) than those given ({len(list(phones))}; "
            f"{shown}); give the phones.tsv of the network's own run, or train the network anew."
        )
    if len(aam.texture_mean) != 3 * speaker.reference.size:
        raise DataError(
            f"the appearance model has textures of {len(aam.texture_mean) // 3} pixels, the reference grid "
            f"{speaker.reference.size}; give the reference.safetensors of the same run."
        )


def resting_frames(
    alignment: Alignment, frames: int, rate: float, after: float = 0.25, before: float = 0.5
) -> np.ndarray:
    """Frames of one utterance in which the face is at rest, (frames,) bool: silence away from speech.

    The mouth closes soon after speech, but opens long before it, to draw breath.

    Parameters
    ----------
    frames, rate : number of frames and frame rate (Hz) of the visual stream
    after, before : minimum time in seconds after speech and before speech
    """
    times, resting = frame_times(frames, rate), np.ones(frames, bool)
    for phone in alignment.phones:
        if phone.label != SILENCE:
            resting &= (times < phone.start - before) | (times > phone.end + after)
    return resting


def resting_face(utterances: Callable[[], Iterable[tuple]]) -> np.ndarray:
    """The face at rest, (N,) float32: mean over long silences, or over short ones where no utterance has a long one.

    Parameters
    ----------
    utterances : returns, each time it is called, an iterable of (:class:`Alignment`, appearance (frames, N), rate in
        Hz), one item per utterance, so that they need not be in memory together

    Raises
    ------
    DataError
        No utterance has silence.
    """

    def silences(**away) -> Iterator[np.ndarray]:
        return (values[resting_frames(spoken, len(values), rate, **away)] for spoken, values, rate in utterances())

    # Recordings that are cut close to the speech have no long silence.
    return rest_of(silences() if any(map(len, silences())) else silences(**_SHORT_SILENCE))


def rest_of(silences: Iterable[np.ndarray]) -> np.ndarray:
    """The face at rest, (N,) float32: the mean over all frames of silence.

    Parameters
    ----------
    silences : appearance (frames, N) of these frames, one array per utterance

    Raises
    ------
    DataError
        There are no such frames.
    """
    total, count = 0.0, 0
    for appearance in silences:
        total, count = total + np.asarray(appearance, np.float64).sum(axis=0), count + len(appearance)
    if not count:
        raise DataError(
            "the training utterances have no silence that shows the face at rest; record with half a second of silence "
            "before and after each sentence."
        )
    return (total / count).astype(np.float32)


def describe_bundle(
    folder: str | Path, phones, shares: Mapping, rest: np.ndarray, corpus: str, model: str, consent: str
) -> None:
    """Write the rest face and ``speaker.json`` into a folder that holds the other parts.

    Raises
    ------
    DataError
        The parts do not fit each other.
    """
    folder = Path(folder)
    write_model(folder / FILES["rest"], {"appearance": np.asarray(rest, np.float32)}, {"kind": "rest"})
    network = Network.load(folder / FILES["network"])
    speaker = Speaker(
        HeadModel.load(folder / FILES["head"]),
        Aam.load(folder / FILES["aam"]),
        Reference.load(folder / FILES["reference"]),
    )
    parts = {name: file_digest(folder / FILES[name]) for name in PARTS}
    check_together(network, speaker, parts["aam"], phones)
    about = {
        "kind": KIND,
        "version": VERSION,
        "corpus": corpus,
        "model": model,
        "consent": consent,
        "rate": network.rate,
        "phones": list(phones),
        "state_shares": {phone: [round(float(value), 5) for value in values] for phone, values in shares.items()},
        "parts": parts,
    }
    write_text(folder / DESCRIPTION, json.dumps(about, indent=1, sort_keys=True) + "\n")


def _description(folder: Path) -> dict:
    path = folder / DESCRIPTION
    if not path.is_file():
        raise StorageError(
            f"{folder} is no speaker: it holds no {DESCRIPTION}. Give the folder that the workflow's target `speaker` "
            "has written, results/<corpus>/<experiment>/speakers/<model>."
        )
    try:
        about = json.loads(read_text(path))
    except ValueError as error:
        raise StorageError(f"{path} is damaged ({error}). Make the speaker anew.") from error
    if not isinstance(about, dict) or about.get("kind") != KIND or not _is_complete(about):
        raise StorageError(f"{path} does not describe a speaker of this project. Make the speaker anew.")
    if about.get("version") != VERSION:
        raise StorageError(
            f"{folder} is a speaker of version {about.get('version')}, this program reads {VERSION}. Make it anew."
        )
    return about


def _is_complete(about: dict) -> bool:
    """Whether a description holds all that is read of it, each of its kind."""

    def is_share(values) -> bool:
        return isinstance(values, list) and len(values) == 3 and all(isinstance(one, int | float) for one in values)

    parts, phones, shares = (about.get(key) for key in ("parts", "phones", "state_shares"))
    return (
        all(isinstance(about.get(key), str) for key in ("corpus", "model", "consent"))
        and isinstance(parts, dict)
        and isinstance(phones, list)
        and all(isinstance(phone, str) for phone in phones)
        and isinstance(shares, dict)
        and all(map(is_share, shares.values()))
    )
