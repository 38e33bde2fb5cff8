"""What the input blocks ``speech27`` and ``speech44`` share: features of the sound, normalised per speaker.

The features (:mod:`visualspeech.speech.speech_features`) have a rate of 120 Hz and are brought to that of the visual
stream by :func:`visualspeech.features.resampling.resample`. At 120 Hz and above they are interpolated linearly
(Sadoughi 2017, section 3.2). At a lower rate, such as that of a camera, each frame has the mean of that line over its
duration, because values at the centres of frames would miss what happens between them.

Each feature is then z-normalised: less its mean, over its standard deviation. With ``scaling: speaker``, as in the
paper, both are those of the training utterances of the speaker. For a speaker of the corpus without training
utterances they are those of all utterances of this speaker, and for new speech, whose speaker is not known, those of
the recording. With ``scaling: corpus`` they are those of all training utterances.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from typing import ClassVar

import numpy as np

from visualspeech.errors import DamagedFile, DataError
from visualspeech.features.blocks.base import Source
from visualspeech.features.resampling import resample
from visualspeech.features.streams import Layout, Stream
from visualspeech.fields import Settings, setting
from visualspeech.speech.sound import BLOCK, Sound, between_voiced, spans
from visualspeech.speech.speech_features import ALL_NAMES, PRAAT_NAMES, RATE, Extractor
from visualspeech.storage.layouts import Array, FileLayout
from visualspeech.timing import frames_in

LIMIT = 10.0  # largest absolute value of a normalised feature
MIN_DEVIATION = 0.1  # of a speaker, as a share of the corpus's, so that noise in a silent recording is not scaled up
MAX_SPEAKERS = 100_000
SCALINGS = ("speaker", "corpus")
_FLOOR, _CEILING = (40.0, 200.0), (250.0, 1000.0)  # Hz


@dataclass(frozen=True)
class SpeechSettings(Settings):
    """Settings of the blocks ``speech27`` and ``speech44``."""

    section: ClassVar[str] = "blocks"

    scaling: str = setting(
        "speaker",
        "Mean and deviation of the z-normalisation: speaker, those of the speaker's training utterances, or of the "
        "speaker's own sound where there are none; corpus, those of all training utterances.",
        choices=SCALINGS,
    )
    pitch_floor: float = setting(
        75.0,
        "Lowest F0 in Hz that is looked for; the window of the pitch analysis holds three periods of it.",
        minimum=_FLOOR[0],
        maximum=_FLOOR[1],
    )
    pitch_ceiling: float = setting(
        600.0, "Highest F0 in Hz that is looked for.", minimum=_CEILING[0], maximum=_CEILING[1]
    )


@dataclass(frozen=True, eq=False)
class Sums:
    """Sums over frames from which mean and deviation of D features follow; frames without a value are not counted.

    Parameters
    ----------
    count, total, squares : (D,) number of values, their sum and the sum of their squares
    """

    count: np.ndarray
    total: np.ndarray
    squares: np.ndarray

    @classmethod
    def of(cls, values: np.ndarray) -> "Sums":
        """Of values (T, D), NaN where there is none."""
        known = ~np.isnan(values)
        values = np.where(known, values, 0)
        return cls(known.sum(axis=0), values.sum(axis=0), (values**2).sum(axis=0))

    def __add__(self, other: "Sums") -> "Sums":
        return Sums(self.count + other.count, self.total + other.total, self.squares + other.squares)

    def normaliser(self, corpus: "Normaliser | None" = None) -> "Normaliser":
        """Mean and deviation; those of the corpus for features without a value, and no deviation far below its."""
        count = np.maximum(self.count, 1)
        mean = self.total / count
        deviation = np.sqrt(np.maximum(self.squares / count - mean**2, 0))
        if corpus is None:
            # A feature that never varies stays 0.
            return Normaliser(mean, np.where(deviation > 1e-6 * (1 + abs(mean)), deviation, 1.0))
        floored = np.maximum(deviation, MIN_DEVIATION * corpus.deviation)
        return Normaliser(*(np.where(self.count, *pair) for pair in ((mean, corpus.mean), (floored, corpus.deviation))))


@dataclass(frozen=True, eq=False)
class Normaliser:
    """Mean and deviation (D,) of features."""

    mean: np.ndarray
    deviation: np.ndarray

    def apply(self, values: np.ndarray) -> np.ndarray:
        """Normalised values (T, D) float32; 0, the mean, where there is none."""
        normalised = np.clip((values - self.mean) / self.deviation, -LIMIT, LIMIT)
        return np.where(np.isnan(normalised), 0, normalised).astype(np.float32)


@dataclass(frozen=True, eq=False)
class SpeechBlock:
    """The features of each frame, normalised. A subclass says which features they are.

    Parameters
    ----------
    options : see there
    corpus : statistics of all training utterances
    speakers : those of each speaker; empty with ``scaling: corpus``
    """

    kind: ClassVar[str]
    descriptors: ClassVar[bool]
    needs: ClassVar[tuple[str, ...]] = ("audio",)
    settings: ClassVar[type | None] = SpeechSettings

    options: SpeechSettings
    corpus: Normaliser
    speakers: Mapping[str, Normaliser]

    def __eq__(self, other) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        (arrays, plain), (others, also) = self.state(), other.state()
        return plain == also and all(np.array_equal(values, others[name]) for name, values in arrays.items())

    @classmethod
    def fit(cls, settings: Mapping, phones: Sequence[str], training: Iterable[Source]) -> "SpeechBlock":
        """Statistics of the training utterances; one of them is in memory at a time.

        Raises
        ------
        DataError
            There is no training utterance.
        """
        options = SpeechSettings(**settings)
        sums = _sums_of_speakers(cls._extractor(options), training)
        if not sums:
            raise DataError("there is no training utterance to learn from. Add recordings, or change `split`.")
        first, *others = sums.values()
        corpus = sum(others, first).normaliser()
        return cls(options, corpus, _normalisers(sums, corpus) if options.scaling == "speaker" else {})

    def with_speakers(self, sources: Iterable[Source]) -> "SpeechBlock":
        """With statistics of speakers who have no training utterance, from all utterances of theirs."""
        if self.options.scaling != "speaker":
            return self
        found = _normalisers(_sums_of_speakers(self._extractor(self.options), sources), self.corpus)
        return replace(self, speakers={**found, **self.speakers})

    @property
    def layout(self) -> Layout:
        return Layout(dimension=len(self.names()))

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """Names of the columns, in their order."""
        return ALL_NAMES if cls.descriptors else PRAAT_NAMES

    def encode(self, sources: Sequence[Source]) -> Iterator[Stream]:
        """The stream of each utterance.

        Raises
        ------
        DataError
            An utterance has no sound.
        """
        extractor = self._extractor(self.options)
        for one in sources:
            sound = _sound_of(one, self.kind)
            if self.options.scaling == "corpus":
                normaliser = self.corpus
            else:
                # Sums of new speech are of the whole recording, of which the source may be a part.
                known = self.speakers.get(one.speaker) if one.speaker else None
                normaliser = known or _sums_of_sound(extractor, sound, one.rate).normaliser(self.corpus)
            yield Stream(values=normaliser.apply(features_at(extractor, sound, one.frames, one.rate, one.begin)))

    def for_new_speech(self) -> "SpeechBlock":
        """The block without the speakers of the corpus."""
        return replace(self, speakers={})

    def state(self) -> tuple[dict[str, np.ndarray], dict]:
        # The first row is the corpus's, which every block has.
        rows = [self.corpus, *self.speakers.values()]
        arrays = {name: np.stack([getattr(row, name) for row in rows]) for name in ("mean", "deviation")}
        return arrays, {**asdict(self.options), "speakers": list(self.speakers)}

    @classmethod
    def restore(cls, arrays: Mapping[str, np.ndarray], plain: Mapping) -> "SpeechBlock":
        """The inverse of :meth:`state`.

        Raises
        ------
        DamagedFile
            There is not one row for each speaker.
        """
        names = plain["speakers"]
        if len(arrays["mean"]) != len(names) + 1:
            raise DamagedFile("", f"it has statistics of {len(arrays['mean']) - 1} speakers and {len(names)} names")
        options = SpeechSettings(**{name: value for name, value in plain.items() if name != "speakers"})
        corpus, *rows = (Normaliser(*row) for row in zip(arrays["mean"], arrays["deviation"], strict=True))
        return cls(options, corpus, dict(zip(names, rows, strict=True)))

    @classmethod
    def _extractor(cls, options: SpeechSettings) -> Extractor:
        return Extractor(cls.descriptors, options.pitch_floor, options.pitch_ceiling)


def stored(features: int) -> FileLayout:
    """Layout of the state of a block of so many features."""
    return FileLayout(
        {
            "mean": Array("f", ("R", features), -1e9, 1e9),
            "deviation": Array("f", ("R", features), 1e-12, 1e9),
        },
        {
            "scaling": {"enum": list(SCALINGS)},
            "pitch_floor": {"type": "number", "minimum": _FLOOR[0], "maximum": _FLOOR[1]},
            "pitch_ceiling": {"type": "number", "minimum": _CEILING[0], "maximum": _CEILING[1]},
            "speakers": {
                "type": "array",
                "maxItems": MAX_SPEAKERS,
                "uniqueItems": True,
                "items": {"type": "string", "maxLength": 1000},
            },
        },
    )


def features_at(extractor: Extractor, sound: Sound, frames: int, rate: float, begin: float = 0.0) -> np.ndarray:
    """Features (frames, D) float64 of a sound at the frames of a visual stream, NaN where one has no value.

    Before the first and after the last frame of the features they are constant.

    Parameters
    ----------
    frames, rate : of the visual stream
    begin : time in seconds in the sound of its beginning
    """
    total = extractor.frames(sound)
    # Two frames more on either side than the stream lasts: its means are of lines between the centres of frames.
    first = int(np.clip(np.floor(begin * RATE) - 2, 0, total - 1))
    last = int(np.clip(np.ceil((begin + frames / rate) * RATE) + 2, first + 1, total))
    values = extractor.features(sound, first, last)
    values = np.column_stack([between_voiced(column) for column in values.T])  # a stretch can be without voice
    silent = np.isnan(values).any(axis=0)
    found = resample(np.where(silent, 0.0, values), RATE, rate, frames, begin - first / RATE)
    return np.where(silent, np.nan, found)


def _sums_of_speakers(extractor: Extractor, sources: Iterable[Source]) -> dict[str, Sums]:
    """Sums over the utterances of each speaker, by name in the order of the alphabet."""
    found: dict[str, Sums] = {}
    for one in sources:
        values = features_at(extractor, _sound_of(one), one.frames, one.rate, one.begin)
        own = Sums.of(values)
        found[one.speaker] = found[one.speaker] + own if one.speaker in found else own
    return dict(sorted(found.items()))


@lru_cache(maxsize=1)  # the pieces of a long recording follow each other and share them
def _sums_of_sound(extractor: Extractor, sound: Sound, rate: float) -> Sums:
    """Sums over a whole sound, of which some seconds are in memory at a time."""
    total = max(frames_in(sound.seconds, rate), 1)
    parts = (
        Sums.of(features_at(extractor, sound, last - first, rate, first / rate))
        for first, last in spans(total, max(1, int(BLOCK * rate)))
    )
    return sum(parts, next(parts))


def _normalisers(sums: Mapping[str, Sums], corpus: Normaliser) -> dict[str, Normaliser]:
    return {name: one.normaliser(corpus) for name, one in sums.items()}


def _sound_of(source: Source, kind: str = "of speech features") -> Sound:
    if source.sound is None:
        raise DataError(f"the input block {kind} is computed from sound, and there is none.")
    return source.sound
