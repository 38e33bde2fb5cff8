"""The dynamic viseme of every frame: of the recorded face (oracle), or predicted from the text (Thangthai 2016)."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import ClassVar

import numpy as np

from visualspeech.errors import DamagedFile, DataError
from visualspeech.features.blocks.base import Source
from visualspeech.features.streams import Layout, Stream
from visualspeech.features.visemes.classes import POINTS, VisemeClasses, fit_classes
from visualspeech.features.visemes.prediction import MIN_ERROR, CrossFit, Labelled, TextModel, fit_text_model
from visualspeech.features.visemes.segmentation import Gestures, gestures_of, resampled
from visualspeech.features.visemes.text_features import number_of_codes
from visualspeech.fields import MAX_SEED, Settings, setting
from visualspeech.storage.layouts import PHONES, Array, FileLayout, check_arrays
from visualspeech.storage.models import part_of

MAX_CLASSES = 10_000
LARGEST = 2**56  # value of an array of the state: digests of ids
_SMOOTHING, _LENGTH, _FOLDS = (0.001, 1.0), (0.0, 10.0), (2, 10)
SOURCES = ("oracle", "predicted")


@dataclass(frozen=True)
class DynamicVisemesSettings(Settings):
    """Settings of the block ``dynamic_visemes``."""

    section: ClassVar[str] = "blocks"

    source: str = setting(
        "predicted",
        "Whose visemes a model reads: oracle, those of the recorded face, which only a recording has; predicted, those "
        "predicted from the phones and their times.",
        choices=SOURCES,
    )
    classes: int = setting(160, "Number of classes of dynamic visemes.", minimum=2, maximum=MAX_CLASSES)
    smoothing: float = setting(
        0.04,
        "Standard deviation in seconds of the Gaussian window over which the face's speed is taken.",
        minimum=_SMOOTHING[0],
        maximum=_SMOOTHING[1],
    )
    min_length: float = setting(0.06, "Least length of a gesture in seconds.", minimum=_LENGTH[0], maximum=_LENGTH[1])
    folds: int = setting(
        5,
        "Parts of the training utterances; the visemes of each are predicted by a model of the others.",
        minimum=_FOLDS[0],
        maximum=_FOLDS[1],
    )
    seed: int = setting(1, "Seed of the classes.", minimum=0, maximum=MAX_SEED)


@dataclass(frozen=True, eq=False)
class DynamicVisemes:
    """The class of the gesture that each frame belongs to: one column of N classes.

    Parameters
    ----------
    phones : inventory of the corpus
    classes : of the gestures of the training utterances
    options : see there
    text : the model that predicts visemes; None for those of the recorded face
    """

    kind: ClassVar[str] = "dynamic_visemes"
    needs: ClassVar[tuple[str, ...]] = ("text", "faces")
    settings: ClassVar[type | None] = DynamicVisemesSettings
    stored: ClassVar[FileLayout] = FileLayout(
        {
            "means": Array("f", ("N", POINTS, "D"), -1e9, 1e9),
            "counts": Array("iu", ("N",), 0, 1e12),
            "text.*": Array("fiu", None),
            "crossfit.*": Array("fiu", None, high=LARGEST),
        },
        {
            "phones": PHONES,
            "source": {"enum": list(SOURCES)},
            "classes": {"type": "integer", "minimum": 2, "maximum": MAX_CLASSES},
            "smoothing": {"type": "number", "minimum": _SMOOTHING[0], "maximum": _SMOOTHING[1]},
            "min_length": {"type": "number", "minimum": _LENGTH[0], "maximum": _LENGTH[1]},
            "folds": {"type": "integer", "minimum": _FOLDS[0], "maximum": _FOLDS[1]},
            "seed": {"type": "integer", "minimum": 0, "maximum": MAX_SEED},
            "error": {"type": "number", "minimum": 0, "maximum": 1e18},
        },
    )

    phones: tuple[str, ...]
    classes: VisemeClasses
    options: DynamicVisemesSettings = DynamicVisemesSettings()
    text: TextModel | None = None

    def __eq__(self, other) -> bool:
        if not isinstance(other, DynamicVisemes):
            return NotImplemented
        (arrays, plain), (others, also) = self.state(), other.state()
        return (
            plain == also
            and arrays.keys() == others.keys()
            and all(np.array_equal(values, others[name]) for name, values in arrays.items())
        )

    @classmethod
    def encoding_needs(cls, settings: Mapping) -> tuple[str, ...]:
        """What a stream is computed from: the recorded face alone, or the text alone."""
        return ("faces",) if settings["source"] == "oracle" else ("text",)

    @property
    def encoded_from(self) -> tuple[str, ...]:
        """As :meth:`encoding_needs`, of this block."""
        return self.encoding_needs({"source": self.options.source})

    @classmethod
    def fit(cls, settings: Mapping, phones: Sequence[str], training: Iterable[Source]) -> "DynamicVisemes":
        """Classes of the recorded gestures and, for predicted visemes, the model that predicts them.

        Parameters
        ----------
        training : gone through once, for predicted visemes three times

        Raises
        ------
        DataError
            There is no training utterance, or there are fewer gestures than classes.
        """
        options = DynamicVisemesSettings(**settings)
        training = list(training) if iter(training) is training else training
        classes = fit_classes((resampled(*_recorded(one, options), POINTS) for one in training), options.classes,
                              options.seed)  # fmt: skip
        block = cls(tuple(phones), classes, options)
        if options.source == "oracle":
            return block

        def labelled() -> Iterator[Labelled]:
            for one in training:
                values, gestures = _recorded(one, options)
                yield Labelled(one.id, one.alignment, values, one.rate, gestures, classes.assign(values, gestures))

        return cls(tuple(phones), classes, options, fit_text_model(labelled, phones, options.classes, options.folds))

    @property
    def layout(self) -> Layout:
        return Layout(sizes=(len(self.classes),))

    def visemes(self, source: Source) -> tuple[Gestures, np.ndarray]:
        """The gestures of an utterance, and the class (G,) of each.

        Raises
        ------
        DataError
            The visemes are those of the recorded face, and there is no recording, or one of another visual coding.
        """
        if self.text is None:
            values, gestures = _recorded(source, self.options)
            if values.shape[1] != self.classes.means.shape[2]:
                raise DataError(
                    f"a recorded face of {values.shape[1]} parameters has no dynamic visemes of "
                    f"{self.classes.means.shape[2]}: they are of another visual coding. Delete the features of the "
                    "system and run again."
                )
            return gestures, self.classes.assign(values, gestures)
        asked = source.alignment, source.frames, source.rate, self.phones, source.id
        values, shares = self.text.predict(*asked)
        gestures = gestures_of(values, source.rate, self.options.smoothing, self.options.min_length)
        return gestures, self.text.classes_of(self.classes, values, shares, gestures)

    def encode(self, sources: Sequence[Source]) -> Iterator[Stream]:
        """The stream of each utterance; raises as :meth:`visemes`."""
        for one in sources:
            gestures, classes = self.visemes(one)
            yield Stream(index=classes.astype(np.uint16)[gestures.of_frames(), None])

    def for_new_speech(self) -> "DynamicVisemes":
        """The block without the models that only training utterances need."""
        if self.text is None or self.text.crossfit is None:
            return self
        parts = {name: value for name, value in vars(self.text).items() if name != "crossfit"}
        return DynamicVisemes(self.phones, self.classes, self.options, TextModel(**parts))

    def state(self) -> tuple[dict[str, np.ndarray], dict]:
        arrays, text = dict(vars(self.classes)), self.text
        if text is not None:
            arrays |= {f"text.{name}": getattr(text, name) for name in _TEXT}
        if text is not None and text.crossfit is not None:
            arrays |= {f"crossfit.{name}": values for name, values in vars(text.crossfit).items()}
        plain = {"phones": list(self.phones), **asdict(self.options), "error": 0.0 if text is None else text.error}
        return arrays, plain

    @classmethod
    def restore(cls, arrays: Mapping[str, np.ndarray], plain: Mapping) -> "DynamicVisemes":
        """The inverse of :meth:`state`.

        Raises
        ------
        DamagedFile
            The arrays do not fit each other or the settings.
        """
        options = DynamicVisemesSettings(
            **{name: value for name, value in plain.items() if name not in ("phones", "error")}
        )
        phones, classes = tuple(plain["phones"]), VisemeClasses(arrays["means"], arrays["counts"])
        text, crossfit = part_of(arrays, "text"), part_of(arrays, "crossfit")
        if len(classes) != options.classes or bool(text) != (options.source == "predicted"):
            raise DamagedFile("", "its classes of visemes are not those of its settings")
        if not text:
            return cls(phones, classes, options)
        sizes = {"N": len(classes), "M": len(classes) + classes.means.shape[2], "L": len(classes) + 1}
        known = {"known": Array("iu", ("F",), 0, number_of_codes(len(phones)) - 1)}
        sizes = check_arrays("", text, {**_TEXT, **known}, sizes)
        if crossfit:
            check_arrays("", crossfit, _CROSSFIT, sizes)
        if any((np.diff(values.astype(np.int64)) <= 0).any() for values in (text["known"], *_sorted(crossfit))):
            raise DamagedFile("", "the indicators of its visemes or its utterances are not sorted")
        made = CrossFit(**crossfit) if crossfit else None
        return cls(phones, classes, options, TextModel(**text, error=max(plain["error"], MIN_ERROR), crossfit=made))


#: F indicators, M columns of N classes and D parameters, K folds, U training utterances; L is N + 1.
_TEXT = {
    "known": Array("iu", ("F",), 0),
    "weights": Array("f", ("F", "M"), -1e9, 1e9),
    "offsets": Array("f", ("M",), -1e9, 1e9),
    "follows": Array("f", ("L", "N"), -1e3, 0),
}
_CROSSFIT = {
    "training": Array("iu", ("U",), 0, LARGEST),
    "weights": Array("f", ("K", "F", "M"), -1e9, 1e9),
    "offsets": Array("f", ("K", "M"), -1e9, 1e9),
}


def _sorted(crossfit: Mapping[str, np.ndarray]) -> list[np.ndarray]:
    return [crossfit["training"]] if crossfit else []


def _recorded(source: Source, options: DynamicVisemesSettings) -> tuple[np.ndarray, Gestures]:
    """Recorded parameters (T, D) of an utterance and its gestures."""
    if source.parameters is None:
        raise DataError(
            "the input block dynamic_visemes reads the visemes of a recorded face (`source: oracle`), and new speech "
            "has none. Name a model that reads predicted ones (`source: predicted`)."
        )
    values = np.asarray(source.parameters, np.float32)
    return values, gestures_of(values, source.rate, options.smoothing, options.min_length)


BLOCK = DynamicVisemes
