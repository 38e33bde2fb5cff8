"""The streams of one utterance at one frame rate: labels and what they are to be mapped to."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from visualspeech.features.labels import label_indices
from visualspeech.features.resampling import resample
from visualspeech.fields import Settings, setting


@dataclass(frozen=True)
class FeatureSettings(Settings):
    """Frame rate of the streams that models learn from (Fan 2015, section 5.1: 25)."""

    section = "features"
    rate: float = setting(
        25.0, "Frame rate of labels and visual parameters in Hz; 0 keeps that of the video.", minimum=0, maximum=1000
    )


def feature_streams(
    rows, visual: Mapping[str, np.ndarray], video_rate: float, phones: Sequence[str], settings: FeatureSettings
) -> tuple[dict[str, np.ndarray], float]:
    """Labels (T, 4) and every visual stream of an utterance, resampled to T frames; and their rate in Hz.

    Parameters
    ----------
    rows : alignment of the utterance
    visual : streams (frames, n) at ``video_rate`` Hz
    phones : the inventory
    """
    rate = settings.rate or video_rate
    resampled = {name: resample(values, video_rate, rate) for name, values in visual.items()}
    frames = len(next(iter(resampled.values())))
    return {"labels": label_indices(rows, frames, rate, phones), **resampled}, rate
