"""The phones that a model knows, and what it predicts from a new alignment."""

import numpy as np

from visualspeech.features.blocks.base import Source
from visualspeech.features.blocks.base import phones_of as inventory_of
from visualspeech.models.task import Model
from visualspeech.speech.alignment import Alignment


def phones_of(model: Model) -> tuple[str, ...]:
    """Inventory of the input blocks of a model; empty where no block reads phones."""
    return next(filter(None, map(inventory_of, model.blocks.values())), ())


def predict_alignment(model: Model, alignment: Alignment, frames: int) -> np.ndarray:
    """Parameters (frames, N) float32 of new speech at the model's rate.

    Raises
    ------
    DataError
        The alignment has phones that the model does not know.
    """
    source = Source(frames, model.rate, alignment)
    streams = [next(iter(block.encode([source]))) for block in model.blocks.values()]
    return model.predict(streams, frames, model.rate)
