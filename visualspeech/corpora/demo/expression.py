"""The course of an emotion in one utterance."""

import numpy as np

from visualspeech.corpora.demo.characters import MOVEMENTS, Emotion
from visualspeech.speech.phones import SILENCE

_HELD = 0.7  # share of an emotion that the face holds throughout; the rest comes and goes with the speech
_ACCENT = 0.25  # raise of the brows on accents, of any emotion
_VARIATION = 0.12  # standard deviation of the strength of an emotion, between utterances


def course(emotion: Emotion, words: tuple, phones: tuple, times: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Amounts (T, M) of the movements of a face, in the order of ``MOVEMENTS``, at ``times`` (T,) seconds.

    Parameters
    ----------
    words, phones : (label, start, end) in seconds
    """
    speech = _smooth_steps([(start, end) for phone, start, end in phones if phone != SILENCE], times, 0.15)
    accents = _smooth_steps([(start, end) for _, start, end in words[:: max(1, len(words) // 2)]], times, 0.1)
    strength = max(0.5, 1 + random.normal(0, _VARIATION))
    held = strength * (_HELD + (1 - _HELD) * speech)
    amounts = np.stack([emotion.face.get(name, 0.0) * held for name in MOVEMENTS], axis=1)
    amounts[:, list(MOVEMENTS).index("brows")] += _ACCENT * accents
    return amounts


def _smooth_steps(spans: list[tuple[float, float]], times: np.ndarray, width: float) -> np.ndarray:
    """1 inside any of the spans (start, end), 0 far from all, with smooth flanks of about ``width`` seconds."""
    inside = np.zeros(len(times))
    for start, end in spans:
        rise, fall = (1 / (1 + np.exp(-4 * (times - at) / width)) for at in (start, end))
        inside = np.maximum(inside, rise - fall)
    return np.clip(inside, 0, 1)
