"""Speaker bundles: one self-contained folder with everything needed to synthesise a talking head of a speaker.

The parts are ``model.safetensors``, ``aam.safetensors``, ``reference.safetensors``, ``head.safetensors``,
``rest.safetensors`` (the face at rest), ``background.h5`` and, where the system has one, ``sound.safetensors``: a model
that reads sound alone, for recordings without a text; and ``dictionary.txt``, where the run has a pronunciation
dictionary of its own. ``speaker.json`` holds the digest of each part, the phones, the
average shares of their states, and whose face it is. The folder can be moved and shared.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from visualspeech.animation.background import Background
from visualspeech.animation.descriptions import read_description
from visualspeech.animation.showable import BoundedModel, check_showable
from visualspeech.animation.video import Speaker
from visualspeech.errors import DamagedFile, DataError, SettingError, StorageError
from visualspeech.face.aam.model import Aam
from visualspeech.face.aam.reference import Reference
from visualspeech.face.head import HeadModel
from visualspeech.models.inventory import needs_of_model, phones_of
from visualspeech.models.registry import load_model
from visualspeech.models.task import Model
from visualspeech.provenance import file_digest
from visualspeech.speech.dictionary import Dictionary, read_dictionary
from visualspeech.speech.lexicon import Lexicon
from visualspeech.storage.files import write_text
from visualspeech.storage.layouts import PHONES, RATE, TEXT, Array, FileLayout
from visualspeech.storage.models import read_model_of, write_model

KIND = "visualspeech speaker"
VERSION = 4
REMEDY = "Build the speaker again, or ask for the folder again where it was received."
DESCRIPTION = "speaker.json"
PARTS = ("model", "aam", "reference", "head", "rest", "background")
SOUND, DICTIONARY = "sound", "dictionary"  # the parts that a speaker need not have
FILES = {name: f"{name}.safetensors" for name in (*PARTS, SOUND)} | {
    "background": "background.h5",
    DICTIONARY: "dictionary.txt",
}


@dataclass(frozen=True)
class SpeakerBundle:
    """A speaker for whom videos of any text can be synthesised.

    Parameters
    ----------
    trained : model of any family, from speech to the parameters of the visual coding
    speaker : head, appearance model, texture grid
    background : recorded frames onto which the lower face is stitched
    rest : (N,) appearance of the face at rest
    shares : phone -> average shares of its duration that its three states take
    sound : model that reads sound alone and speaks for recordings without a text; None where there is none
    dictionary : pronunciations of one's own, which come before those of the voice and the recogniser; None for none
    corpus, model, sound_model, consent : for the metadata of videos
    digest : of the whole bundle
    """

    trained: Model
    speaker: Speaker
    background: Background
    rest: np.ndarray
    shares: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    sound: Model | None = None
    dictionary: Dictionary | None = None
    corpus: str = ""
    model: str = ""
    sound_model: str = ""
    consent: str = ""
    digest: str = ""

    @property
    def reads_sound_alone(self) -> bool:
        """Whether its model itself needs no text: it can show nothing but sound."""
        return needs_of_model(self.trained) == {"audio"}

    @property
    def pronunciation(self) -> Callable[[str], Sequence[str]] | None:
        """Function of a word, for :func:`visualspeech.speech.spoken.speak_text`; None without a dictionary."""
        return self.dictionary and self.dictionary.spoken

    def lexicon(self) -> Lexicon:
        """The pronunciations with which a recording is aligned."""
        return Lexicon(own=self.dictionary and self.dictionary.pronunciations())

    def for_recordings(self) -> "SpeakerBundle":
        """The speaker as it speaks for a recording without a text: with its second model, where it has one."""
        return self if self.sound is None else replace(self, trained=self.sound, model=self.sound_model, sound=None)

    @classmethod
    def load(cls, folder: str | Path) -> "SpeakerBundle":
        """The bundle in a folder, checked for parts that do not belong together.

        Raises
        ------
        StorageError
            The folder is not a bundle, or a part is missing or damaged.
        DataError
            A part has been changed or replaced, or the parts do not fit each other or show no face.
        """
        folder = Path(folder)
        about = _description(folder)
        for name, expected in about["parts"].items():
            path = folder / FILES[name]
            if not path.is_file():
                raise StorageError(f"the speaker {folder} lacks {path.name}. Copy the whole folder, or build it again.")
            if file_digest(path) != expected:
                raise DataError(
                    f"{path} is not the file that this speaker was made of (digest {file_digest(path)}, not "
                    f"{expected}): parts of two speakers were mixed, or the file was changed. Build the speaker again."
                )
        try:
            trained = load_model(folder / FILES["model"])
            sound = load_model(folder / FILES[SOUND]) if SOUND in about["parts"] else None
            speaker = Speaker.load(*(folder / FILES[name] for name in ("head", "aam", "reference")))
            rest = _rest(folder / FILES["rest"])
            own = _dictionary(folder / FILES[DICTIONARY]) if DICTIONARY in about["parts"] else None
            background = Background.load(folder / FILES["background"])
        except DamagedFile as error:
            raise DamagedFile(error.path, error.reason, REMEDY) from error
        try:
            check_together(trained, speaker, about["parts"]["aam"], about["phones"])
            if sound is not None:
                check_sound_model(sound, speaker, about["parts"]["aam"])
        except DataError as error:
            raise DataError(f"the parts of the speaker {folder} do not fit each other: {error}") from error
        if rest.shape != (trained.outputs,):
            raise DataError(f"{folder / FILES['rest']} is a face of another appearance model. Build the speaker again.")
        sizes = background.shapes.shape[1], background.textures.shape[1]
        if sizes != (len(speaker.aam.shape_mean), len(speaker.aam.texture_mean)):
            raise DataError(f"{folder / FILES['background']} is of another appearance model. Build the speaker again.")
        check_showable(folder, speaker, background, rest)
        return cls(
            trained=BoundedModel(trained, speaker, str(folder / FILES["model"])),
            dictionary=own,
            sound=sound and BoundedModel(sound, speaker, str(folder / FILES[SOUND])),
            speaker=speaker,
            background=background,
            rest=rest,
            shares={phone: tuple(values) for phone, values in about["state_shares"].items()},
            corpus=about["corpus"],
            model=about["model"],
            sound_model=about["sound_model"],
            consent=about["consent"],
            digest=file_digest(folder / DESCRIPTION),
        )


def check_together(trained: Model, speaker: Speaker, aam_digest: str, phones) -> None:
    """Check, before any long work, that a model, an appearance model and an inventory of phones belong together.

    Parameters
    ----------
    aam_digest : digest of the file of the appearance model

    Raises
    ------
    DataError
        The model was trained for others, or the texture grid is of another appearance model.
    """
    size, aam = len(speaker.aam.appearance_components), speaker.aam
    if "faces" in needs_of_model(trained):
        raise DataError(
            "the model reads dynamic visemes of the recording (`source: oracle`), and new speech has none; name a "
            "model with predicted ones."
        )
    if trained.outputs != size or (trained.coding and trained.coding != aam_digest):
        raise DataError(
            f"the model was trained for another appearance model (digest {trained.coding or 'not known'}, "
            f"{trained.outputs} components) than the one given (digest {aam_digest}, {size} components); give the "
            "appearance model of the same run, or train the model again."
        )
    known = phones_of(trained)
    if known and list(known) != list(phones):
        differ = sorted(set(known) ^ set(phones))
        shown = f"{', '.join(differ[:6])} in only one of them" if differ else "in another order"
        raise DataError(
            f"the model was trained for other phones ({len(known)}) than those given ({len(list(phones))}; {shown}); "
            "give the phones.tsv of the same run, or train the model again."
        )
    if len(aam.texture_mean) != 3 * speaker.reference.size:
        raise DataError(
            f"the appearance model has textures of {len(aam.texture_mean) // 3} pixels, the reference grid "
            f"{speaker.reference.size}; give the reference.safetensors of the same run."
        )


def check_sound_model(sound: Model, speaker: Speaker, aam_digest: str) -> None:
    """As :func:`check_together`, of the model that speaks for recordings without a text.

    Raises
    ------
    DataError
        It does not read sound alone, or was trained for another appearance model.
    """
    if needs_of_model(sound) != {"audio"}:
        raise DataError(
            "the model for recordings without a text must read sound and nothing else; name another in `sound_model` "
            "of the system, or none."
        )
    check_together(sound, speaker, aam_digest, ())


def describe_bundle(
    folder: str | Path,
    phones,
    shares: Mapping,
    rest: np.ndarray,
    corpus: str,
    model: str,
    consent: str,
    sound_model: str = "",
) -> None:
    """Write the face at rest and ``speaker.json`` into a folder that holds the other parts.

    Raises
    ------
    DataError
        The parts do not fit each other.
    """
    folder = Path(folder)
    write_model(folder / FILES["rest"], {"appearance": np.asarray(rest, np.float32)}, {"kind": "rest"})
    trained = load_model(folder / FILES["model"])
    speaker = Speaker(
        HeadModel.load(folder / FILES["head"]),
        Aam.load(folder / FILES["aam"]),
        Reference.load(folder / FILES["reference"]),
    )
    given = [
        *PARTS,
        *([SOUND] if sound_model else []),
        *([DICTIONARY] if (folder / FILES[DICTIONARY]).exists() else []),
    ]
    parts = {name: file_digest(folder / FILES[name]) for name in given}
    check_together(trained, speaker, parts["aam"], phones)
    if sound_model:
        check_sound_model(load_model(folder / FILES[SOUND]), speaker, parts["aam"])
    about = {
        "kind": KIND,
        "version": VERSION,
        "corpus": corpus,
        "model": model,
        "sound_model": sound_model,
        "consent": consent,
        "rate": trained.rate,
        "phones": list(phones),
        "state_shares": {phone: [round(float(value), 5) for value in values] for phone, values in shares.items()},
        "parts": parts,
    }
    write_text(folder / DESCRIPTION, json.dumps(about, indent=1, sort_keys=True) + "\n")


def _rest(path: Path) -> np.ndarray:
    layout = FileLayout({"appearance": Array("f", ("N",), -1e9, 1e9)})
    return read_model_of(path, "face at rest", ["rest"], layout)[0]["appearance"]


def _dictionary(path: Path) -> Dictionary:
    try:
        return read_dictionary(path)
    except SettingError as error:
        raise DamagedFile(path, f"it is no pronunciation dictionary ({error})", REMEDY) from error


def parts_of(folder: str | Path) -> dict[str, str]:
    """Digest of each part of a speaker; raises StorageError where the folder is none."""
    return _description(Path(folder))["parts"]


def _description(folder: Path) -> dict:
    origin = "Give a folder written by the workflow's target `speaker`, results/<corpus>/<system>/speakers/<model>."
    return read_description(folder / DESCRIPTION, "speaker", KIND, VERSION, _SCHEMA, origin, REMEDY)


_SHARE = {"type": "number", "minimum": 0, "maximum": 1}
_PROPERTIES = {
    "kind": {"const": KIND},
    "version": {"const": VERSION},
    "corpus": TEXT,
    "model": TEXT,
    "sound_model": TEXT,
    "consent": TEXT,
    "rate": RATE,
    "phones": PHONES,
    "state_shares": {
        "type": "object",
        "additionalProperties": {"type": "array", "minItems": 3, "maxItems": 3, "items": _SHARE},
    },
    "parts": {
        "type": "object",
        "required": list(PARTS),
        "additionalProperties": False,
        "properties": dict.fromkeys((*PARTS, SOUND, DICTIONARY), TEXT),
    },
}
_SCHEMA = {
    "type": "object",
    "required": list(_PROPERTIES),
    "additionalProperties": False,
    "properties": _PROPERTIES,
}
