"""Log-mel spectra of the sound: what networks read that are driven by a recording and not by a text.

A system's frame lasts longer than a sound changes, so a frame holds the spectra of several equal parts of it side by
side, as many as come closest to the wanted step: at 25 frames per second and a step of 10 ms the four of 100 Hz.

Level and channel are removed for each recording by itself, since a listener's recording has others than the training's
and knows nothing of them: each band less its mean over the recording's speech, over its deviation there. A recording
that hardly varies is not blown up, because the deviation has a floor, and no value is larger than a limit.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar

import numpy as np

from visualspeech.errors import DataError
from visualspeech.features.blocks.base import Source
from visualspeech.features.streams import Layout, Stream
from visualspeech.fields import Settings, setting
from visualspeech.speech.acoustics import BandStatistics, MelBands, band_statistics
from visualspeech.speech.sound import RATE, Sound
from visualspeech.storage.layouts import FileLayout

LIMIT = 4.0  # largest size of a normalised value
MIN_DEVIATION = 3.0  # dB; what varies less over a recording, as steady noise does, is not scaled up
UNNORMALISED = (-50.0, 20.0)  # dB; mean and deviation without normalisation, so that inputs are near unit variance
NORMALISATIONS = ("variance", "mean", "none")
MAX_BANDS, MAX_PER_FRAME = 80, 1000
_LOW, _HIGH = 1000, 2000  # Hz; between these no band is narrower than what the Fourier transform tells apart
_WINDOW, _STEP, _RANGE = (0.005, 0.2), (0.001, 0.1), (1.0, 200.0)


@dataclass(frozen=True)
class LogMelSettings(Settings):
    """Settings of the block ``log_mel``."""

    section: ClassVar[str] = "blocks"

    bands: int = setting(28, "Number of mel bands.", minimum=1, maximum=MAX_BANDS)
    low_hz: float = setting(60.0, "Lower border of the lowest band in Hz.", minimum=0, maximum=_LOW)
    high_hz: float = setting(
        7600.0,
        f"Upper border of the highest band in Hz; recordings are kept at {RATE / 1000:g} kHz.",
        minimum=_HIGH,
        maximum=RATE / 2,
    )
    window: float = setting(0.025, "Length of a spectrum's window in seconds.", minimum=_WINDOW[0], maximum=_WINDOW[1])
    step: float = setting(
        0.01,
        "Time between spectra in seconds; a frame holds those of as many equal parts of it as come closest to this.",
        minimum=_STEP[0],
        maximum=_STEP[1],
    )
    normalisation: str = setting(
        "variance",
        "What is removed of each band over a recording's speech: mean and variance, the mean alone, or nothing.",
        choices=NORMALISATIONS,
    )
    speech_range: float = setting(
        30.0,
        "Sound down to so many dB below the loud parts of a recording counts as speech in the normalisation; 200: all.",
        minimum=_RANGE[0],
        maximum=_RANGE[1],
    )

    @property
    def mel_bands(self) -> MelBands:
        """The filter bank and its window."""
        return MelBands(self.bands, self.low_hz, self.high_hz, self.window)


@dataclass(frozen=True)
class LogMel:
    """Normalised log-mel bands of each part of a frame, side by side.

    Parameters
    ----------
    bands : the filter bank
    step : seconds between the spectra over which a recording's mean and variance are taken
    normalisation : of :data:`NORMALISATIONS`
    speech_range : dB below the loud parts that count as speech
    per_frame : spectra of a frame
    """

    kind: ClassVar[str] = "log_mel"
    needs: ClassVar[tuple[str, ...]] = ("audio",)
    settings: ClassVar[type | None] = LogMelSettings
    stored: ClassVar[FileLayout] = FileLayout(
        plain={
            "bands": {"type": "integer", "minimum": 1, "maximum": MAX_BANDS},
            "low_hz": {"type": "number", "minimum": 0, "maximum": _LOW},
            "high_hz": {"type": "number", "minimum": _HIGH, "maximum": RATE / 2},
            "window": {"type": "number", "minimum": _WINDOW[0], "maximum": _WINDOW[1]},
            "step": {"type": "number", "minimum": _STEP[0], "maximum": _STEP[1]},
            "normalisation": {"enum": list(NORMALISATIONS)},
            "speech_range": {"type": "number", "minimum": _RANGE[0], "maximum": _RANGE[1]},
            "per_frame": {"type": "integer", "minimum": 1, "maximum": MAX_PER_FRAME},
        }
    )

    bands: MelBands
    step: float
    normalisation: str
    speech_range: float
    per_frame: int

    @classmethod
    def fit(cls, settings: Mapping, phones: Sequence[str], training: Iterable[Source]) -> "LogMel":
        """The block for the frame rate of the first training utterance.

        Raises
        ------
        DataError
            There is no training utterance.
        """
        own = LogMelSettings(**settings)
        first = next(iter(training), None)
        if first is None:
            raise DataError("there is no training utterance to learn from. Add recordings, or change `split`.")
        per_frame = min(max(1, round(1 / (first.rate * own.step))), MAX_PER_FRAME)
        return cls(own.mel_bands, own.step, own.normalisation, own.speech_range, per_frame)

    @property
    def layout(self) -> Layout:
        return Layout(dimension=self.bands.bands * self.per_frame)

    def encode(self, sources: Sequence[Source]) -> Iterator[Stream]:
        """The stream of each utterance.

        Raises
        ------
        DataError
            An utterance has no sound.
        """
        for one in sources:
            if one.sound is None:
                raise DataError("the input block log_mel is computed from sound, and there is none.")
            parts = one.frames * self.per_frame
            times = one.begin + (np.arange(parts) + 0.5) / (one.rate * self.per_frame)
            known = statistics_of(self, one.sound)
            values = (self.bands.spectra(one.sound, times) - known.mean) / known.deviation
            values = np.clip(values, -LIMIT, LIMIT).astype(np.float32)
            yield Stream(values=values.reshape(one.frames, self.layout.dimension))

    def state(self) -> tuple[dict[str, np.ndarray], dict]:
        own = {name: value for name, value in vars(self).items() if name != "bands"}
        return {}, {**vars(self.bands), **own}

    @classmethod
    def restore(cls, arrays: Mapping[str, np.ndarray], plain: Mapping) -> "LogMel":
        own = {name: value for name, value in plain.items() if name != "per_frame"}
        settings = LogMelSettings(**own)
        return cls(settings.mel_bands, settings.step, settings.normalisation, settings.speech_range, plain["per_frame"])


@lru_cache(maxsize=1)  # the pieces of a long recording follow each other and share them
def statistics_of(block: LogMel, sound: Sound) -> BandStatistics:
    """What is subtracted from each band of a recording, and what it is divided by."""
    if block.normalisation == "none":
        return BandStatistics(*(np.full(block.bands.bands, value) for value in UNNORMALISED))
    found = band_statistics(sound, block.bands, block.step, block.speech_range)
    if block.normalisation == "mean":
        return BandStatistics(found.mean, np.full(block.bands.bands, UNNORMALISED[1] / 2))
    return BandStatistics(found.mean, np.maximum(found.deviation, MIN_DEVIATION))


BLOCK = LogMel
