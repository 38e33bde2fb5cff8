"""The face at rest that a talking head shows in pauses, beside what models predict there.

The other tables measure predictions as they are. A talking head blends a face at rest into the pauses
(:func:`visualspeech.animation.performance.perform`), because what a model shows there trembles. What that costs or
gains in RMSE(appearance) is measured here, on the pauses of the recorded test utterances.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence

import numpy as np

from visualspeech.evaluation.layout import Cell, Row, Table, interval, shown
from visualspeech.evaluation.measured import MeasuredRows
from visualspeech.evaluation.metrics import Metric
from visualspeech.evaluation.scoring import centred, frame_rmse
from visualspeech.evaluation.statistics import BootstrapSettings, Sampled, draws, figure, sample_row
from visualspeech.models.rest import REST, pause_weights, resting_face
from visualspeech.speech.alignment import Alignment

#: Frames that are measured: name -> (heading, count of frames).
PARTS = {"all": ("all frames", "frames"), "pauses": ("frames in pauses", "pause_frames")}
FORMS = {"predicted": "as predicted", "rest": "face at rest in pauses"}
COLUMNS = ("row", "part", *(f"{name}{end}" for name in (*FORMS, "difference") for end in ("", "_low", "_high")))


def training_rest(alignments: Callable[[], Iterable[tuple[str, Alignment]]], targets) -> np.ndarray:
    """The face at rest, (N,) float32, of training utterances (:func:`visualspeech.models.rest.resting_face`).

    Parameters
    ----------
    alignments : gives id and alignment of each training utterance, each time it is called
    targets : opened files of the recorded appearance parameters
    """
    return resting_face(
        lambda: ((found, targets.array(name, "appearance"), targets.rate(name)) for name, found in alignments())
    )


def resting_rows(
    alignments: Iterable[tuple[str, Alignment]], predictions, targets, rest: np.ndarray, ramp: float = REST
) -> Iterator[dict]:
    """Statistics of test utterances: sums of centred frame errors (Eq. 18) as predicted and with the face at rest.

    Parameters
    ----------
    alignments : id and alignment of each utterance
    predictions, targets : opened files of predicted and recorded appearance parameters
    rest : (N,) from :func:`training_rest`
    ramp : seconds from the border of a pause until the face is fully at rest
    """
    for name, alignment in alignments:
        true, rate = targets.array(name, "appearance"), targets.rate(name)
        predicted = predictions.array(name, "appearance")
        weight = pause_weights(alignment, len(true), rate, ramp)
        blended = (1 - weight[:, None]) * predicted + weight[:, None] * rest
        row = {"id": name, "rate": rate, "frames": len(true), "pause_frames": int((weight > 0).sum())}
        for form, values in zip(FORMS, (predicted, blended), strict=True):
            error = frame_rmse(centred(values), centred(true))
            row |= {f"all_{form}_sum": float(error.sum()), f"pauses_{form}_sum": float(error[weight > 0].sum())}
        yield row


def resting_frame(measured: MeasuredRows, bootstrap: BootstrapSettings):
    """Figures of all rows as a data frame with :data:`COLUMNS`; ``difference`` is at rest minus as predicted, paired.

    Parameters
    ----------
    measured : with tables of :func:`resting_rows`; repetitions are pooled
    """
    import pandas

    measured, lines = measured.pooled(), []
    drawn = draws(measured.utterances, bootstrap)
    for row in measured.tables:
        for part, (_, frames) in PARTS.items():
            metrics = [Metric(form, form, "", "low", (f"{part}_{form}_sum", frames)) for form in FORMS]
            one, other = (sample_row(measured, row, metric, drawn, bootstrap) for metric in metrics)
            difference = Sampled(other.value - one.value, other.samples - one.samples)
            figures = [figure(each, bootstrap.level) for each in (one, other, difference)]
            lines.append((row, part, *(value for each in figures for value in (each.value, each.low, each.high))))
    return pandas.DataFrame(lines, columns=list(COLUMNS))


def resting_tables(
    frame, measured: MeasuredRows, facts: Sequence[tuple[str, str]], bootstrap: BootstrapSettings, digits: int = 3
) -> tuple[Table]:
    """The table for readers; parameters as made by and given to :func:`resting_frame`."""
    measured = measured.pooled()
    found = {(line.row, line.part): line for line in frame.itertuples()}
    names = (*FORMS, "difference")
    rows = tuple(
        Row(
            row.title,
            tuple(_cell(found[row.name, part], name, digits) for part in PARTS for name in names),
            row.role,
        )
        for row in measured.rows
    )
    share = sum(table["pause_frames"].sum() for table in measured.tables.values())
    share /= sum(table["frames"].sum() for table in measured.tables.values())
    return (
        Table(
            "RMSE(appearance) with the face at rest in pauses",
            (*FORMS.values(), "difference") * len(PARTS),
            rows,
            groups=tuple((heading, len(names)) for heading, _ in PARTS.values()),
            facts=(*facts, ("intervals", bootstrap.text(measured)), ("frames in pauses", f"{share:.0%}")),
            notes=(
                "A talking head blends the mean face of the training utterances' silence into pauses. Below 0, that "
                "face is nearer to the recorded one than what the model predicts.",
            ),
        ),
    )


def _cell(line, name: str, digits: int) -> Cell:
    value, low, high = (shown(getattr(line, f"{name}{end}"), digits) for end in ("", "_low", "_high"))
    return Cell(value, interval(low, high))
