"""What models predict: the parameters of a visual coding, brought to a system's frame rate."""

from collections.abc import Mapping

import numpy as np

from visualspeech.features.resampling import resample


def target_streams(
    visual: Mapping[str, np.ndarray], video_rate: float, rate: float
) -> tuple[dict[str, np.ndarray], float]:
    """Every visual stream of an utterance at a system's rate, and that rate in Hz.

    Parameters
    ----------
    visual : streams (frames, n) at ``video_rate`` Hz
    rate : Hz; 0 keeps the video's own
    """
    wanted = rate or video_rate
    return {name: resample(values, video_rate, wanted) for name, values in visual.items()}, wanted
