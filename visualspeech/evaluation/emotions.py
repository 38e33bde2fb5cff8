"""Models by region of the face and emotion of the utterance: Fig. 5 of Sadoughi and Busso (2017), and its figures.

All test utterances of an emotion are one sequence, as all test utterances are one in the table by region. Utterances
without an emotion are left out of this table only.
"""

from collections.abc import Mapping, Sequence

from visualspeech.evaluation import plots
from visualspeech.evaluation.layout import Cell, Row, Table, best_of, competes, definitions_of, interval, shown
from visualspeech.evaluation.measured import MeasuredRows
from visualspeech.evaluation.metrics import ABSOLUTE, CENTRED, PROTOCOLS, Metric
from visualspeech.evaluation.published_results import Published
from visualspeech.evaluation.region_settings import EmotionSettings
from visualspeech.evaluation.region_table import groups_of, headings_of, knowledge_note, regions_of, without_region
from visualspeech.evaluation.statistics import BootstrapSettings, draws, figure, sample_row

MEASURES = ("ccc", "mse")
COLUMNS = ("emotion", "utterances", "frames", "row", "metric", "value", "low", "high")


def shown_emotions(emotions: Mapping[str, str], settings: EmotionSettings) -> list[str]:
    """The emotions that enough utterances have, the most frequent first.

    Parameters
    ----------
    emotions : id of a test utterance -> its emotion, empty for none
    """
    return [name for name, count in counted(emotions).items() if count >= settings.min_utterances]


def counted(emotions: Mapping[str, str]) -> dict[str, int]:
    """Number of utterances by emotion, the most frequent first, equal ones by name; without those that have none."""
    found = [one for one in emotions.values() if one]
    return {name: found.count(name) for name in sorted(set(found), key=lambda name: (-found.count(name), name))}


def emotion_frame(
    measured: MeasuredRows,
    emotions: Mapping[str, str],
    settings: EmotionSettings,
    bootstrap: BootstrapSettings | None = None,
):
    """All figures by emotion as a data frame with :data:`COLUMNS`, one line per emotion, row and measure.

    Parameters
    ----------
    measured : the rows that are compared; repetitions are pooled
    emotions : id of an utterance -> its emotion, empty for none
    settings : of the table
    bootstrap : of the intervals
    """
    import pandas

    bootstrap, lines = bootstrap or BootstrapSettings(), []
    metrics = _metrics(measured)
    for emotion in shown_emotions(_of_test(measured, emotions), settings):
        pooled = measured.on([one for one, own in emotions.items() if own == emotion]).pooled()
        drawn = draws(pooled.utterances, bootstrap)
        for row in pooled.rows:
            for metric in metrics:
                found = figure(sample_row(pooled, row.name, metric, drawn, bootstrap), bootstrap.level)
                place = (emotion, pooled.utterances, pooled.frames, row.name, metric.name)
                lines.append((*place, found.value, found.low, found.high))
    return pandas.DataFrame(lines, columns=list(COLUMNS))


def _metrics(measured: MeasuredRows) -> list[Metric]:
    grouped = (regions_of(measured, protocol, MEASURES) for protocol in (ABSOLUTE, CENTRED))
    return [metric for one in grouped for own in one.values() for metric in own]


def _of_test(measured: MeasuredRows, emotions: Mapping[str, str]) -> dict[str, str]:
    """The emotions of the utterances that are measured."""
    table = next(iter(measured.tables.values()))
    return {one: emotions.get(one, "") for one in table["id"]}


def emotion_tables(
    frame,
    measured: MeasuredRows,
    emotions: Mapping[str, str],
    settings: EmotionSettings,
    facts: Sequence[tuple[str, str]],
    bootstrap: BootstrapSettings,
    paper: Published | None = None,
    digits: int = 3,
    needs: Mapping[str, Sequence[str]] | None = None,
) -> tuple[Table, ...]:
    """The tables of :func:`emotion_frame`: in the absolute protocol, which is the paper's, and in the centred one.

    Parameters
    ----------
    frame, measured, emotions, settings, bootstrap : as made by and given to :func:`emotion_frame`
    facts : what the figures were computed on
    paper : whose numbers of utterances stand below the table
    needs : input block -> what it is computed from
    """
    pooled, own = measured.pooled(), _of_test(measured, emotions)
    text = {
        (line.emotion, line.row, line.metric): tuple(shown(v, digits) for v in (line.value, line.low, line.high))
        for line in frame.itertuples()
    }
    counts = counted(own)
    said = ", ".join(f"{count} {name}" for name, count in counts.items()) or "none"
    without = len(own) - sum(counts.values())
    facts = (
        *facts,
        ("test utterances by emotion", said),
        ("without an emotion, left out here", str(without)),
        ("shown", f"emotions of {settings.min_utterances} test utterances or more"),
        ("intervals", bootstrap.text(pooled)),
    )
    tables, known = [], knowledge_note(pooled.rows, needs or {})
    for protocol, title in ((ABSOLUTE, "Emotions"), (CENTRED, "Emotions, centred")):
        grouped = regions_of(pooled, protocol, MEASURES)
        if not grouped:
            continue
        first = not tables
        tables.append(
            Table(
                title,
                headings_of(grouped),
                _rows(frame, pooled, [metric for each in grouped.values() for metric in each], text),
                groups=groups_of(grouped),
                facts=(*(facts if first else ()), ("protocol", PROTOCOLS[protocol])),
                notes=(*_notes(frame, counts, settings, paper), *known) if first else (),
                definitions=definitions_of([without_region(one) for one in next(iter(grouped.values()))]),
            )
        )
    return tuple(tables)


def _rows(frame, pooled: MeasuredRows, metrics: Sequence[Metric], text: Mapping) -> tuple[Row, ...]:
    rows = []
    for emotion, part in frame.groupby("emotion", sort=False):
        line = part.iloc[0]
        rows.append(Row(f"{emotion}: {line.utterances} utterances, {line.frames} frames"))
        best = {
            (name, metric.name)
            for metric in metrics
            for name in best_of(
                metric, {row.name: text[emotion, row.name, metric.name][0] for row in pooled.rows if competes(row)}
            )
        }
        for row in pooled.rows:
            keys = [(emotion, row.name, metric.name) for metric in metrics]
            cells = (Cell(text[key][0], interval(*text[key][1:]), best=key[1:] in best) for key in keys)
            rows.append(Row(row.title, tuple(cells), row.role))
    return tuple(rows)


def _notes(frame, counts: Mapping[str, int], settings: EmotionSettings, paper: Published | None) -> tuple[str, ...]:
    notes = ["The best value of each emotion and column is bold."]
    if not len(frame):
        notes = [
            f"No emotion has {settings.min_utterances} test utterances. Lower `tables.emotions.min_utterances` of the "
            "system to show those with fewer."
        ]
    elif len(left_out := [name for name, count in counts.items() if count < settings.min_utterances]):
        notes.append(f"With fewer test utterances, not shown: {', '.join(left_out)}.")
    if paper is not None and paper.emotions:
        said = ", ".join(f"{count} {name}" for name, count in paper.emotions.items())
        notes.append(
            f"The paper shows its figures as a plot only (Fig. 5), of these test turns: {said}. {paper.source}."
        )
    return tuple(notes)


def emotion_figure(frame, measured: MeasuredRows) -> bytes:
    """The PNG of :func:`visualspeech.evaluation.plots.grouped_bars`: both measures by region, emotion and row.

    In the absolute protocol where the rows have it, as the paper's figure.

    Parameters
    ----------
    frame, measured : as made by and given to :func:`emotion_frame`
    """
    pooled = measured.pooled()
    grouped = regions_of(pooled, ABSOLUTE, MEASURES) or regions_of(pooled, CENTRED, MEASURES)
    titles, panels = pooled.titles, {}
    for number, measure in enumerate(MEASURES):
        for region, metrics in grouped.items():
            part = frame[frame["metric"] == metrics[number].name]
            values = {
                titles[name]: {line.emotion: (line.value, line.low, line.high) for line in own.itertuples()}
                for name, own in part.groupby("row", sort=False)
            }
            panels[f"{measure.upper()}, {region} face"] = values
    return plots.grouped_bars(panels, len(grouped))
