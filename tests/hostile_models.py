"""Altered speaker folders: what a stranger, a bad disk or a mistaken hand may make of the files of a speaker.

:func:`campaign` alters one thing per case, signs it as an attacker would (or leaves the digests as damage would), loads
it and uses what was loaded. Allowed are an error of the library that names the file, and finite results::

    from tests.hostile_models import campaign, make

    for outcome in campaign(make(folder), folder / "work", seed=1, count=10_000):
        assert not outcome.problem, outcome

With the same seed, the first cases of a longer campaign are those of a shorter one.
"""

import copy
import json
import shutil
import warnings
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tests.alterations import alter_arrays, alter_background, alter_bytes, alter_plain
from tests.unit.animation import speakers
from visualspeech.animation.background import Background
from visualspeech.animation.bundle import DESCRIPTION, FILES, SpeakerBundle, check_together
from visualspeech.animation.performance import face_of
from visualspeech.animation.showable import BoundedModel, check_showable
from visualspeech.animation.speaking import speaking_frames
from visualspeech.animation.video import Speaker
from visualspeech.errors import VisualSpeechError
from visualspeech.face.aam.model import Aam
from visualspeech.face.aam.reference import Reference, texture_image
from visualspeech.face.head import HeadModel
from visualspeech.features.blocks.base import Source
from visualspeech.features.blocks.dynamic_visemes import DynamicVisemes
from visualspeech.features.blocks.full_context import FullContext
from visualspeech.features.blocks.linguistic import Linguistic
from visualspeech.features.blocks.phone import Phone
from visualspeech.features.blocks.phone_track import PhoneTrack, PhoneTrackSettings
from visualspeech.features.blocks.speech27 import Speech27
from visualspeech.features.blocks.triphone_state import TriphoneState
from visualspeech.features.blocks.viseme_context import VisemeContext
from visualspeech.features.examples import Example
from visualspeech.models import dnn, ensemble, gv_compensation, joint, lookup, mean, stack
from visualspeech.models.hmm import family as hmm
from visualspeech.models.registry import load_model
from visualspeech.models.rows import ModelRow
from visualspeech.models.task import Task
from visualspeech.provenance import file_digest
from visualspeech.speech.sound import RATE, Sound
from visualspeech.speech.spoken import timed
from visualspeech.storage.arrays import ArrayReader
from visualspeech.storage.models import read_model, write_model

PHONES = ("sil", "aa", "b", "iy", "m", "s")
#: One of each family, HSMMs that read numbers beside phones, a stack of sound, one of contextual features, one of
#: dynamic visemes, a network of convolutions with dynamic outputs, and one with regions.
MODELS = (
    "stack", "convolutions", "dnn", "hmm", "hsmm", "lookup", "mean", "ensemble", "gv_compensation", "linguistic",
    "visemes", "sound", "joint", "speech",
)  # fmt: skip
BY_FRAME = {"batcher": "shuffled_frames", "objective": "mse", "scaling": "dimension"}
WHOLE = 0.02  # share of the cases that load a whole folder and render it
RENDERED = 0.2  # share of the loaded folders of which a frame is rendered, which takes longest
SLOW = {"background": 0.3, "speaker": 0.3, "rest": 0.2}  # weights of parts whose cases take longest; others have 1


class Outcome(NamedTuple):
    """What came of one case: its number and description, the message of the error if any, and what must not be."""

    number: int
    case: str
    error: str = ""
    problem: str = ""


def make(folder: Path) -> Path:
    """Write a small speaker with a model of every family (``model_<name>.safetensors``); returns its folder."""
    made = speakers.make(Path(folder) / "speaker", PHONES)
    bundle, coding = SpeakerBundle.load(made), file_digest(made / FILES["aam"])
    shutil.copyfile(made / FILES["model"], made / "model_stack.safetensors")
    shutil.copyfile(made / FILES["sound"], made / "model_sound.safetensors")
    spread, random = np.sqrt(bundle.speaker.aam.appearance_variances), np.random.default_rng(0)

    noise = np.random.default_rng(3).normal(0, 2000, (2, 16_000)).astype(np.int16)
    sounds = [Source(25, 25.0, sound=Sound(samples), speaker="speaker") for samples in noise]

    def task(family, settings, *kinds, parents=(), options=None):
        blocks, examples = {block.kind: block for block in kinds}, []
        for _ in range(6):
            alignment = spoken(random.permutation(PHONES[1:]))
            source = Source(25, 25.0, alignment, sounds[0].sound, speaker="speaker")
            streams = tuple(next(iter(block.encode([source]))) for block in kinds)
            target = bundle.rest + 0.3 * spread * random.normal(size=(25, len(bundle.rest)))
            examples.append(Example(streams, target.astype(np.float32), 25.0))
        row = ModelRow("model", "Model", family, settings, tuple(blocks), options or {})
        return Task(row, blocks, examples, examples, coding, parents)

    # HMMs with all that a file of them can hold: phones divided at the times of their states.
    track = PhoneTrack(PHONES, PhoneTrackSettings("aligned"))
    small = {"states": 3, "rate": 50.0, "min_frames": 2.0, "mdl_factor": 0.01, "untied_iterations": 1}
    hmm.fit(task("hmm", {**small, "variant": "monophone"}, track)).model.save(made / "parent.safetensors")
    tied = task("hmm", {**small, "variant": "tied"}, track, parents=[made / "parent.safetensors"])
    hmm.fit(tied).model.save(made / "model_hmm.safetensors")
    context, small = FullContext(PHONES), {**small, "durations": "gaussian"}
    hmm.fit(task("hmm", {**small, "variant": "monophone"}, context)).model.save(made / "parent.safetensors")
    tied = task("hmm", {**small, "variant": "tied"}, context, parents=[made / "parent.safetensors"])
    hmm.fit(tied).model.save(made / "model_hsmm.safetensors")
    settings = {"context": "triphone", "min_count": 2}
    lookup.fit(task("lookup", settings, TriphoneState(PHONES))).model.save(made / "model_lookup.safetensors")
    mean.fit(task("mean", {}, TriphoneState(PHONES))).model.save(made / "model_mean.safetensors")
    (made / "parent.safetensors").unlink()
    settings = {"letters": "FC", "nodes": 4, "trajectory": "mlpg"}
    convolutions = task("stack", settings, TriphoneState(PHONES), options={"max_epochs": 2})
    stack.fit(convolutions).model.save(made / "model_convolutions.safetensors")
    features = Linguistic.fit({}, PHONES, [Source(25, 25.0, spoken(PHONES[1:])), Source(25, 25.0, spoken(PHONES[3:]))])
    contextual = task("stack", {"letters": "F", "nodes": 4}, Phone(PHONES), features, options={"max_epochs": 2})
    stack.fit(contextual).model.save(made / "model_linguistic.safetensors")
    settings = {"layers": 2, "nodes": 4, "trajectory": "mlpg"}
    windowed = task("dnn", settings, TriphoneState(PHONES), options={"max_epochs": 2, **BY_FRAME})
    windowed = replace(windowed, row=replace(windowed.row, windows={"triphone_state": 0.12}))
    dnn.fit(windowed).model.save(made / "model_dnn.safetensors")
    regions = {"upper": [1], "lower": [0, *range(2, len(bundle.rest))]}
    settings = {"nodes": 4, "shared": 1, "trajectory": "mlpg"}
    joined = replace(task("joint", settings, TriphoneState(PHONES), options={"max_epochs": 2}), regions=regions)
    joint.fit(joined).model.save(made / "model_joint.safetensors")
    visemes = viseme_blocks([bundle.rest + spread * random.normal(size=(25, len(spread))) for _ in range(4)])
    seen = task("stack", {"letters": "F", "nodes": 4}, *visemes, options={"max_epochs": 2})
    stack.fit(seen).model.save(made / "model_visemes.safetensors")
    heard = task("stack", {"letters": "F", "nodes": 4}, Speech27.fit({}, (), sounds), options={"max_epochs": 2})
    stack.fit(heard).model.save(made / "model_speech.safetensors")
    members = [made / f"model_{name}.safetensors" for name in ("convolutions", "hmm", "lookup")]
    blocks = TriphoneState(PHONES), track
    ensemble.fit(task("ensemble", {}, *blocks, parents=members)).model.save(made / "model_ensemble.safetensors")
    compensation = task("gv_compensation", {}, *blocks, parents=[made / "model_ensemble.safetensors"])
    gv_compensation.fit(compensation).model.save(made / "model_gv_compensation.safetensors")
    return made


def viseme_blocks(faces) -> tuple[DynamicVisemes, VisemeContext]:
    """Predicted dynamic visemes and their contexts, learned from the parameters (25, N) of some utterances."""
    recorded = [Source(25, 25.0, spoken(PHONES[1:]), parameters=face, id=str(n)) for n, face in enumerate(faces)]
    visemes = DynamicVisemes.fit({"classes": 3, "folds": 2}, PHONES, recorded)
    return visemes, VisemeContext.fit({"visemes": "dv"}, PHONES, recorded, {"dv": visemes})


def spoken(phones):
    """An alignment of one second with a pause on either side of some phones."""
    times = np.linspace(0.2, 0.8, len(phones) + 1).tolist()
    inner = [(str(phone), *span) for phone, *span in zip(phones, times[:-1], times[1:], strict=True)]
    return timed([("sil", 0.0, 0.2), *inner, ("sil", 0.8, 1.0)])


def campaign(source: Path, work: Path, seed: int, count: int) -> Iterator[Outcome]:
    """Run cases on copies of the speaker ``source`` in the folder ``work``, which it makes; one outcome per case."""
    stage = _Stage(source, work)
    for number in range(count):
        yield stage.run(number, np.random.default_rng([seed, number]))


class _Stage:
    """The parts of a speaker in memory, and the folder in which cases are written."""

    def __init__(self, source: Path, work: Path) -> None:
        self.source, self.work = source, shutil.copytree(source, work)
        self.whole = SpeakerBundle.load(source)
        self.about = json.loads((source / DESCRIPTION).read_text())
        self.models = {name: source / f"model_{name}.safetensors" for name in MODELS}
        self.altered: set[str] = set()  # files in the folder that are not as they were
        there = [name for name in (*FILES.values(), DESCRIPTION) if (source / name).exists()]
        self.sound = {name: (source / name).read_bytes() for name in there}
        names = ("aam", "reference", "head", "rest")
        self.paths = {**self.models, **{name: source / FILES[name] for name in names}}
        self.content = {name: read_model(path) for name, path in self.paths.items()}
        with ArrayReader(source / FILES["background"]) as file:
            self.background = {name: (file[name], file.attributes(name)) for name in file.ids}

    def run(self, number: int, random: np.random.Generator) -> Outcome:
        parts = [*self.paths, "background", "speaker"]
        weights = np.array([SLOW.get(name, 1.0) for name in parts])
        part = str(random.choice(parts, p=weights / weights.sum()))
        file = {"background": FILES["background"], "speaker": DESCRIPTION}.get(part)
        path = self.work / (file or FILES.get(part, FILES["model"]))  # `sound` is a part of the folder, too
        whole = part in ("speaker", "rest") or random.random() < WHOLE
        for name in self.altered if whole else ():
            (self.work / name).write_bytes(self.sound[name])
        self.altered = ({path.name} if whole else self.altered | {path.name}) | ({DESCRIPTION} if whole else set())
        case = f"{part}: {self._alter(part, path, random)}"
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                finite = self._use_folder(part, path, random) if whole else self._use_part(part, path, random)
            return Outcome(number, case, problem="" if finite else "a result is not finite")
        except VisualSpeechError as error:
            named = str(path) in str(error) or str(self.work) in str(error)
            return Outcome(number, case, str(error), "" if named else f"the file is not named: {error}")
        except Exception as error:
            return Outcome(number, case, problem=repr(error))

    def _alter(self, part: str, path: Path, random: np.random.Generator) -> str:
        if part == "speaker":
            about = copy.deepcopy(self.about)
            said = alter_plain(about, random) if random.random() < 0.8 else alter_bytes(path, random)
            if not said.startswith("bytes"):
                path.write_text(_json(about))
            return said
        kind = random.random()
        if part == "background":
            if kind < 0.1:
                return alter_bytes(path, random)
            return alter_background(path, copy.deepcopy(self.background), random)
        if kind < 0.1:
            path.write_bytes(self.paths[part].read_bytes())
            return alter_bytes(path, random)
        arrays, settings = copy.deepcopy(self.content[part])
        said = alter_plain(settings, random) if kind < 0.45 else alter_arrays(arrays, random)
        try:
            write_model(path, arrays, settings)
        except Exception as error:  # what cannot be written is no case
            return f"not written ({error!r})"
        return said

    def _use_part(self, part: str, path: Path, random: np.random.Generator) -> bool:
        """Load one altered part beside the sound others, check it with them, and use it."""
        whole, speaker = self.whole, self.whole.speaker
        if part in MODELS:
            trained = load_model(path)
            try:
                check_together(trained, speaker, self.about["parts"]["aam"], PHONES)
            except VisualSpeechError as error:
                raise VisualSpeechError(f"{path}: {error}") from error
            return _speaks(BoundedModel(trained, speaker, str(path)), whole.rest)
        rest, background = whole.rest, whole.background
        if part == "aam":
            speaker = Speaker(speaker.head, Aam.load(path), speaker.reference)
        elif part == "head":
            speaker = Speaker(HeadModel.load(path), speaker.aam, speaker.reference)
        elif part == "reference":
            reference = Reference.load(path)
            texture = np.zeros(3 * reference.size, np.float32)
            return bool(np.isfinite(reference.weights.sum()) and np.isfinite(texture_image(texture, reference)).all())
        elif part == "background":
            background = Background.load(path)
            frame = background.frame(int(random.integers(len(background))))
            if background.shapes.shape[1] != len(speaker.aam.shape_mean) or frame.ndim != 3:
                return True  # another face, which the whole folder refuses
        if (
            len(speaker.aam.appearance_components) != len(rest)
            or len(speaker.aam.texture_mean) != 3 * (speaker.reference.size)
            or background.textures.shape[1] != len(speaker.aam.texture_mean)
        ):
            return True  # refused where the parts are put together
        check_showable(self.work, speaker, background, rest)
        return all(np.isfinite(one).all() for one in speaker.aam.decode(rest[None]))

    def _use_folder(self, part: str, path: Path, random: np.random.Generator) -> bool:
        """Load the whole folder with digests that fit, let the speaker speak, and sometimes render."""
        if part != "speaker":
            name = next(key for key, file in FILES.items() if file == path.name)
            about = copy.deepcopy(self.about)
            about["parts"][name] = file_digest(path)
            (self.work / DESCRIPTION).write_text(json.dumps(about))
        bundle = SpeakerBundle.load(self.work)
        if random.random() < RENDERED and next(speaking_frames(bundle.rest[None], bundle)).dtype != np.uint8:
            return False
        return _speaks(bundle.trained, bundle.rest) and (bundle.sound is None or _speaks(bundle.sound, bundle.rest))


def _speaks(model, rest: np.ndarray) -> bool:
    samples = np.random.default_rng(1).normal(0, 3000, RATE).astype(np.int16)
    predicted = face_of(spoken(PHONES[1:]), 12, model, rest, 0.1, Sound(samples), 0.1)
    return bool(np.isfinite(predicted).all())


def _json(value) -> str:
    """JSON of a value; lists that are nested more deeply than Python can write are written by hand."""
    try:
        return json.dumps(value)
    except RecursionError:
        return "[" * 100_000 + "]" * 100_000
