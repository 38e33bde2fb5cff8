"""A voice-ready speaker whose face is drawn, for tests of speaking: small models, two short recordings."""

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path

import numpy as np
import torch

from tests.unit.animation.faces import POINTS, draw
from tests.unit.face import heads
from visualspeech.animation.background import write_background
from visualspeech.animation.bundle import FILES, describe_bundle
from visualspeech.face.aam.model import AamSettings, fit
from visualspeech.face.aam.reference import ReferenceSettings, fit_reference, sample_textures
from visualspeech.face.aam.rows import ArrayRows
from visualspeech.face.drift import FaceReference
from visualspeech.face.head import fit_head
from visualspeech.face.point_sets import to_vector
from visualspeech.face.pose import estimate, to_frontal
from visualspeech.features.blocks.base import Block, Source
from visualspeech.features.blocks.log_mel import LogMel
from visualspeech.features.blocks.triphone_state import TriphoneState
from visualspeech.models.batches import Scaling
from visualspeech.models.network import Network
from visualspeech.models.stack import FAMILY, Stack
from visualspeech.models.stack_settings import StackSettings
from visualspeech.provenance import file_digest
from visualspeech.speech.phones import PHONES

CONSENT = "Drawn; it is nobody."
LENGTHS = (40, 30)


def make(folder: Path, phones=PHONES, rate: float = 25.0, seed: int = 4, text: bool = True) -> Path:
    """Write a bundle; its networks have random weights, and say nothing sensible.

    Parameters
    ----------
    text : whether its model reads labels, and a second one sound; otherwise its one model reads sound
    """
    folder.mkdir(parents=True)
    points = heads.record(sum(LENGTHS), seed=seed, mouth=5).points
    recordings = np.split(points, [LENGTHS[0]])
    head = fit_head(points, heads.SIZE)
    frontal = POINTS.select(to_frontal(points, estimate(points, head, rate=rate), head))
    reference = fit_reference([frontal], POINTS, ReferenceSettings(texture_pixels=1200))
    textures = sample_textures((draw(one) for one in points), POINTS.select(points), reference)
    components = {"components": 6}
    settings = AamSettings(shape=components, texture=components, appearance=components)
    shapes = to_vector(frontal)
    zero = FaceReference(np.zeros(102, np.float32), np.zeros(textures.shape[1], np.float32))
    aam = fit(shapes, ArrayRows(textures.astype(np.float32)), POINTS, settings, zero)
    appearance = aam.encode(shapes, textures).appearance
    head.save(folder / FILES["head"])
    aam.save(folder / FILES["aam"])
    reference.save(folder / FILES["reference"])
    labels, mel = {"tri": TriphoneState(tuple(phones))}, {"mel": LogMel.fit({}, (), iter([Source(1, rate)]))}
    coding = file_digest(folder / FILES["aam"])
    network(appearance, labels if text else mel, rate, coding).save(folder / FILES["model"])
    if text:
        network(appearance, mel, rate, coding).save(folder / FILES["sound"])
    write_background(
        folder / FILES["background"],
        (
            (f"r{i}", f"r{i}.mp4", (draw(p) for p in one), one, estimate(one, head, rate=rate), zero, rate)
            for i, one in enumerate(recordings)
        ),
    )
    shares, rest = {"aa": (0.2, 0.5, 0.3)}, appearance.mean(axis=0)
    describe_bundle(folder, phones, shares, rest, "drawn", "F-4", CONSENT, "F-4-mel" if text else "")
    return folder


def network(appearance: np.ndarray, blocks: Mapping[str, Block], rate: float, coding: str) -> Network:
    """A network whose answers spread as the appearance (T, N) of the recordings does."""
    torch.manual_seed(0)
    settings, outputs = StackSettings("F", 4), appearance.shape[1]
    return Network(
        family=FAMILY,
        settings=asdict(settings),
        module=Stack(settings, [block.layout for block in blocks.values()], outputs).eval(),
        scaling=Scaling(appearance.mean(axis=0), np.full(outputs, appearance.std())),
        blocks=blocks,
        rate=rate,
        coding=coding,
    )
