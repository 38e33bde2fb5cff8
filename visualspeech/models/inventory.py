"""What a model reads of speech: the phones that it knows, whether it needs text or sound; and what it predicts."""

import numpy as np

from visualspeech.features.blocks.base import Source, encoding_needs
from visualspeech.features.blocks.base import phones_of as inventory_of
from visualspeech.models.task import Model
from visualspeech.speech.alignment import Alignment


def phones_of(model: Model) -> tuple[str, ...]:
    """Inventory of the input blocks of a model; empty where no block reads phones."""
    return next(filter(None, map(inventory_of, model.blocks.values())), ())


def needs_of_model(model: Model) -> frozenset[str]:
    """What the input blocks of a model are computed from: ``text``, ``audio``, ``faces``; empty for one without."""
    return frozenset(need for block in model.blocks.values() for need in encoding_needs(block))


def predict_alignment(model: Model, alignment: Alignment, frames: int) -> np.ndarray:
    """As :func:`predict_source`, of an alignment alone."""
    return predict_source(model, Source(frames, model.rate, alignment))


def predict_source(model: Model, source: Source) -> np.ndarray:
    """Parameters (frames, N) float32 of new speech at the model's rate.

    Raises
    ------
    DataError
        The alignment has phones that the model does not know, or there is no sound and the model reads it.
    """
    streams = [next(iter(block.encode([source]))) for block in model.blocks.values()]
    return model.predict(streams, source.frames, source.rate)
