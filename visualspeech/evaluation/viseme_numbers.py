"""The number of classes of dynamic visemes, chosen as by Thangthai et al. (2016), section 3: by reconstruction.

For each number, HMMs of the visemes are trained, one for each class, on the recorded visemes of the training
utterances. What they generate from the recorded visemes of held-out utterances is compared with the recording. Beside
them stands the plainest reconstruction: the mean shape of each class, stretched to the length of its gesture.

Measures are those of the paper: of each utterance, RMSE and correlation of each of the first five parameters of the
visual coding, averaged over these.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from visualspeech.evaluation.layout import Cell, Row, Table, shown
from visualspeech.features.blocks.base import Source
from visualspeech.features.blocks.dynamic_visemes import MAX_CLASSES, DynamicVisemes
from visualspeech.fields import Settings, setting
from visualspeech.models.hmm.model import HmmSettings
from visualspeech.models.hmm.segments import Example, PhoneTrack
from visualspeech.models.hmm.training import fit_monophones

COEFFICIENTS = 5
FORMS = {"hmm": "HMMs of the visemes", "mean": "class means"}
MEASURES = {"rmse": "RMSE", "corr": "CORR"}
COLUMNS = ("id", "classes", "gestures", *(f"{measure}_{form}" for form in FORMS for measure in MEASURES))


@dataclass(frozen=True)
class VisemeNumberSettings(Settings):
    """The choice of the number of dynamic visemes (target viseme_numbers)."""

    section = "viseme_numbers"
    block: str = setting(
        "",
        "Input block of kind dynamic_visemes whose gestures are put into classes. Empty: the first one of the system.",
        max_length=32,
    )
    classes: tuple[int, ...] = setting(
        (20, 40, 80, 160, 320),
        "Numbers of classes that are compared.",
        item={"minimum": 2, "maximum": MAX_CLASSES, "description": "Number of classes."},
        min_items=1,
        max_items=100,
        unique=True,
    )


class _Tracks(Sequence):
    """Utterances as HMMs of their visemes are trained on them; parameters are read as they are asked for."""

    def __init__(self, block: DynamicVisemes, sources: Iterable[Source]) -> None:
        self._sources = list(sources)
        self._tracks = [track_of(block, one) for one in self._sources]

    def __len__(self) -> int:
        return len(self._sources)

    def __getitem__(self, number: int) -> Example:
        one = self._sources[number]
        return self._tracks[number], np.asarray(one.parameters), one.rate


def track_of(block: DynamicVisemes, source: Source) -> PhoneTrack:
    """The visemes of an utterance in time, in the place of phones."""
    gestures, classes = block.visemes(source)
    return PhoneTrack(classes[:, None], gestures.starts / source.rate, 0)


def reconstruction_frame(settings: Mapping, training: Iterable[Source], held_out: Iterable[Source]):
    """How well held-out utterances are reconstructed from their visemes: a data frame with :data:`COLUMNS`.

    Parameters
    ----------
    settings : of a block of kind dynamic_visemes, with the number of classes
    training, held_out : utterances with their parameters

    Raises
    ------
    DataError
        There is no training utterance, or there are fewer gestures than classes.
    """
    import pandas

    block = DynamicVisemes.fit({**settings, "source": "oracle"}, (), training)
    names = [str(number) for number in range(len(block.classes))]
    hmm = fit_monophones(_Tracks(block, training), names, HmmSettings())
    rows = []
    for one in held_out:
        gestures, classes = block.visemes(one)
        made = {
            "hmm": hmm.predict(track_of(block, one), one.frames, one.rate),
            "mean": block.classes.reconstruct(classes, gestures),
        }
        true = np.asarray(one.parameters)
        measured = [value for form in FORMS for value in first_coefficients(true, made[form])]
        rows.append((one.id, len(block.classes), len(classes), *measured))
    return pandas.DataFrame(rows, columns=list(COLUMNS))


def first_coefficients(true: np.ndarray, predicted: np.ndarray) -> tuple[float, float]:
    """RMSE and correlation (T, N) of each of the first five parameters, averaged; constant ones have no correlation."""
    true, predicted = (np.asarray(one, np.float64)[:, :COEFFICIENTS] for one in (true, predicted))
    rmse = np.sqrt(np.square(true - predicted).mean(axis=0)).mean()
    one, other = true - true.mean(axis=0), predicted - predicted.mean(axis=0)
    sizes = np.sqrt(np.square(one).sum(axis=0) * np.square(other).sum(axis=0))
    varied = sizes > 0
    correlation = (one * other).sum(axis=0)[varied] / sizes[varied]
    return float(rmse), float(correlation.mean()) if varied.any() else float("nan")


def numbers_table(frame, facts: Mapping[str, str], digits: int = 3) -> Table:
    """The table of :func:`reconstruction_frame` of several numbers of classes.

    Parameters
    ----------
    facts : what the figures were computed on, by name
    """
    rows = []
    for number, own in frame.groupby("classes", sort=True):
        figures = own[list(COLUMNS[3:])]
        cells = [
            Cell(shown(mean, digits), f"±{shown(deviation, digits)}" if deviation == deviation else "")
            for mean, deviation in zip(figures.mean(), figures.std(), strict=True)
        ]
        rows.append(Row(str(number), tuple(cells)))
    first = frame[frame["classes"] == frame["classes"].min()]
    gestures = ("gestures of an utterance", f"{first['gestures'].mean():.1f} on average")
    return Table(
        "Reconstruction from oracle visemes by their number",
        tuple(MEASURES.values()) * len(FORMS),
        tuple(rows),
        groups=tuple((title, len(MEASURES)) for title in FORMS.values()),
        facts=(*facts.items(), ("validation utterances", str(first["id"].nunique())), gestures),
        notes=(
            "Mean and deviation over the validation utterances of measures of the first five parameters. The visemes "
            "are those of the recorded face, so that the figures say what their classes keep, and nothing of a "
            "prediction.",
        ),
        corner="classes",
    )
