"""The streams of one utterance at one frame rate: labels and what they are to be mapped to."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from visualspeech.errors import SettingError
from visualspeech.features.labels import label_indices
from visualspeech.features.resampling import resample
from visualspeech.speech.alignment import Alignment


@dataclass(frozen=True)
class FeatureSettings:
    """The common frame rate of labels and visual parameters in Hz (Fan 2015, section 5.1: 25); 0 keeps the video's."""

    rate: float = 25.0

    def __post_init__(self) -> None:
        if self.rate < 0:
            raise SettingError(f"`features.rate: {self.rate}` must be a frame rate in Hz, or 0 for the video's own.")


def feature_streams(
    alignment: Alignment,
    visual: Mapping[str, np.ndarray],
    video_rate: float,
    phones: Sequence[str],
    settings: FeatureSettings,
) -> tuple[dict[str, np.ndarray], float]:
    """Labels (T, 4) and every visual stream of an utterance, resampled to T frames; and their rate in Hz.

    Parameters
    ----------
    visual : streams (frames, n) at ``video_rate`` Hz
    phones : the inventory
    """
    rate = settings.rate or video_rate
    resampled = {name: resample(values, video_rate, rate) for name, values in visual.items()}
    frames = len(next(iter(resampled.values())))
    return {"labels": label_indices(alignment, frames, rate, phones), **resampled}, rate
