"""Table 1 and Fig. 5 of Sadoughi and Busso (2017), of made-up predictions."""

from dataclasses import replace

import numpy as np
import pandas
import pytest

from visualspeech.errors import SettingError
from visualspeech.evaluation import forms
from visualspeech.evaluation.emotions import (
    counted,
    emotion_figure,
    emotion_frame,
    emotion_tables,
    shown_emotions,
)
from visualspeech.evaluation.measured import MeasuredRows
from visualspeech.evaluation.metrics import corpus_figure
from visualspeech.evaluation.published_results import published, published_of
from visualspeech.evaluation.region_settings import EmotionSettings
from visualspeech.evaluation.region_table import (
    COLUMNS,
    PUBLISHED,
    RUN,
    Cost,
    cost_of,
    knowledge_note,
    region_frame,
    region_tables,
)
from visualspeech.evaluation.regions import region_statistics
from visualspeech.evaluation.scoring import score_table
from visualspeech.evaluation.statistics import BootstrapSettings
from visualspeech.models.rows import ModelRow

REGIONS = {"upper": (0, 1), "middle": (2, 3, 4), "lower": (5,)}
BOOTSTRAP = BootstrapSettings(200, 0.95, 1)
FACTS = (("corpus", "x"), ("split", "abc"))
EMOTIONS = {f"u{i}": ("anger", "neutral", "", "joy", "anger")[i % 5] for i in range(25)} | {"other": "fear"}
COSTS = {
    "separate": Cost(3000, 50, 61.4),
    "joint": Cost(1000, 40, 20),
    "joint-s2": Cost(1000, 20, 10),
    "training_mean": Cost(6),
}


def predictions(share: float, noise: float, seed: int, drift_kept: bool = True):
    truth, generator = np.random.default_rng(0), np.random.default_rng(seed)
    rows = []
    for number in range(25):
        true = truth.normal(size=(30 + number, 6)) + 0.5 * truth.normal(size=6)
        predicted = share * true + noise * generator.normal(size=true.shape)
        rows.append(region_statistics(f"u{number}", predicted, true, 25.0, REGIONS, drift_kept))
    return score_table(rows)


def network(name: str, title: str, **changes) -> ModelRow:
    return ModelRow(name, title, "joint", {"nodes": 64, "layers": 1}, **({"cell": name} | changes))


def found(**changes) -> MeasuredRows:
    rows = (
        network("separate", "Separate-1"),
        network("joint", "Joint-1"),
        network("joint-s2", "Joint-1", seed=2, cell="joint"),
        ModelRow("training_mean", "Training mean", "mean", role="baseline"),
        ModelRow("reconstruction", "Reconstruction (floor)", "reconstruction", role="floor"),
    )
    given = ((0.5, 0.5, 1), (0.6, 0.3, 2), (0.6, 0.3, 3), (0.0, 0.0, 4), (1.0, 0.0, 5))
    tables = (predictions(*one, **changes) for one in given)
    return MeasuredRows(rows, {row.name: table for row, table in zip(rows, tables, strict=True)})


def test_the_table_has_figures_of_the_corpus_and_costs_pooled_over_seeds():
    measured = found()
    frame = region_frame(measured, COSTS, BOOTSTRAP)
    assert tuple(frame.columns) == COLUMNS and set(frame["source"]) == {RUN}
    lines = frame.set_index(["row", "metric"])
    line = lines.loc["separate", "ccc_middle_absolute"]
    assert line["value"] == corpus_figure(measured.tables["separate"], "ccc_middle_absolute")
    assert line["low"] < line["value"] < line["high"]
    assert list(lines.loc["joint", "mse_upper"][["nodes", "parameters", "epochs", "seconds"]]) == [64, 1000, 30, 15]
    assert "joint-s2" not in lines.index
    seeds = [corpus_figure(measured.tables[name], "mse_upper") for name in ("joint", "joint-s2")]
    assert lines.loc["joint", "mse_upper"]["value"] == pytest.approx(np.mean(seeds))
    assert lines.loc["reconstruction", "mse_lower"]["value"] == 0
    assert lines.loc["training_mean", "ccc_lower_absolute"]["value"] == pytest.approx(0)
    assert np.isnan(lines.loc["reconstruction", "mse_lower"][["parameters", "epochs"]].astype(float)).all()


def test_the_layout_is_the_papers_and_its_figures_stand_beside():
    measured, paper = found(), published("sadoughi2017")
    frame = region_frame(measured, COSTS, BOOTSTRAP, paper)
    tables = region_tables(frame, measured, FACTS, BOOTSTRAP, paper)
    first, printed = tables[0], tables[-1]
    assert first.groups == (("", 2), ("Upper face", 2), ("Middle face", 2), ("Lower face", 2), ("Training", 2))
    assert first.columns[:4] == ("Nodes per layer", "Parameters", "CCC\u00a0↑", "MSE\u00a0↓")
    rows = {row.title: [cell.text for cell in row.cells] for row in first.rows}
    assert rows["Separate-1"][:2] == ["64", "3,000"] and rows["Separate-1"][-2:] == ["50", "61"]
    assert rows["Reconstruction (floor)"][2:4] == ["1.000", "0.000"] and rows["Training mean"][-2:] == ["", ""]
    best = {row.title for row in first.rows for cell in row.cells if cell.best}
    assert best == {"Joint-1"}
    assert dict(first.facts)["split"] == "abc" and "absolute" in dict(first.facts)["protocol"]
    assert [table.title for table in tables[1:4]] == [
        "Regions of the face, centred", "Regions of the face per turn", "Regions of the face per turn, centred",
    ]  # fmt: skip
    assert printed.groups[1:] == first.groups[1:4]
    last = printed.rows[-1]
    assert last.title == "Joint-2"
    assert [cell.text for cell in last.cells] == ["512", "23.2M", "0.160", "1.37", "0.307", "1.14", "0.411", "1.06"]
    assert (frame["source"] == PUBLISHED).sum() == 36
    assert frame.set_index("source").loc[PUBLISHED]["parameters"].max() == 50.8e6
    texts = forms.all_forms(frame, tables, "Regions of the face")
    assert all("Joint-1" in text for text in texts) and "Upper face CCC" in texts[1]


def test_the_table_says_what_rows_know():
    rows = [replace(network("a", "Joint-1"), reads=("speech",)), replace(network("b", "B"), reads=("speech", "tri"))]
    needs = {"speech": ("audio",), "tri": ("text",)}
    assert knowledge_note(rows, needs) == (
        "What rows know of a test utterance: its sound alone: Joint-1; its words and the times of its phones and its "
        "sound: B.",
    )


def test_what_the_coding_lacks_is_left_out():
    measured = found(drift_kept=False)
    frame = region_frame(measured, COSTS, BOOTSTRAP)
    tables = region_tables(frame, measured, FACTS, BOOTSTRAP)
    assert [table.title for table in tables] == [
        "Regions of the face, centred",
        "Regions of the face per turn, centred",
    ]
    assert tables[0].columns[1] == "Parameters"
    lower = MeasuredRows(
        measured.rows,
        {name: table[[column for column in table if "upper" not in column]] for name, table in measured.tables.items()},
    )
    table = region_tables(region_frame(lower, COSTS, BOOTSTRAP), lower, FACTS, BOOTSTRAP)[0]
    assert [name for name, _ in table.groups] == ["", "Middle face", "Lower face", "Training"]


def test_cost_of_a_network_and_of_a_model_without_epochs():
    curve = pandas.DataFrame({"epoch": [1, 2, 3], "train": 0.1, "validation": 0.1, "seconds": [1.0, 2.0, 1.5]})
    arrays = {"weights.a": np.zeros((2, 3), np.float32), "mean": np.zeros(5, np.float32)}
    assert cost_of(arrays, curve) == Cost(6, 3, 4.5)
    other = cost_of({"mean": np.zeros(5, np.float32)}, pandas.DataFrame({"iteration": [1]}))
    assert other.parameters == 5 and np.isnan([other.epochs, other.seconds]).all()


def test_a_published_row_needs_all_figures():
    rows = [{"title": "A", "nodes": 1, "parameters": "1M", "figures": [0.1]}]
    given = {"metrics": ["ccc_upper", "mse_upper"], "digits": [1, 1], "rows": rows}
    with pytest.raises(SettingError, match="A must have a figure for each of 2"):
        published_of({"source": "s", "corpus": "c", "regions": given}, "one")


def by_emotion(minimum: int, measured=None):
    measured = measured or found().where(lambda row: row.family == "joint")
    settings = EmotionSettings(min_utterances=minimum)
    frame = emotion_frame(measured, EMOTIONS, settings, BOOTSTRAP)
    paper = published("sadoughi2017")
    return frame, emotion_tables(frame, measured, EMOTIONS, settings, FACTS, BOOTSTRAP, paper), measured


def test_emotions_are_concatenated_and_counted():
    frame, tables, measured = by_emotion(5)
    assert list(dict.fromkeys(frame["emotion"])) == ["anger", "joy", "neutral"]
    angry = [one for one, emotion in EMOTIONS.items() if emotion == "anger"]
    line = frame.set_index(["emotion", "row", "metric"]).loc["anger", "separate", "ccc_upper_absolute"]
    of_anger = measured.tables["separate"]
    of_anger = of_anger[of_anger["id"].isin(angry)]
    assert line["utterances"] == 10 and line["frames"] == of_anger["frames"].sum()
    assert line["value"] == pytest.approx(corpus_figure(of_anger, "ccc_upper_absolute"))
    facts = dict(tables[0].facts)
    # The utterance "other" is no test utterance.
    assert facts["test utterances by emotion"] == "10 anger, 5 joy, 5 neutral"
    assert facts["without an emotion, left out here"] == "5"
    assert [row.title for row in tables[0].rows][:3] == [
        f"anger: 10 utterances, {line['frames']:.0f} frames", "Separate-1", "Joint-1",
    ]  # fmt: skip
    assert any("161 anger" in note for note in tables[0].notes)
    assert "centred" in dict(tables[1].facts)["protocol"]


def test_rare_emotions_are_named_and_not_shown():
    frame, tables, measured = by_emotion(6)
    assert set(frame["emotion"]) == {"anger"}
    assert any("not shown: joy, neutral." in note for note in tables[0].notes)
    frame, tables, measured = by_emotion(11)
    assert not len(frame) and not tables[0].rows
    assert "No emotion has 11 test utterances" in tables[0].notes[0]
    assert emotion_figure(frame, measured).startswith(b"\x89PNG")
    _, markdown, latex, page = forms.all_forms(frame, tables, "Emotions")
    assert "Emotions" in markdown and "Emotions" in page and "% This table has no rows" in latex


def test_emotions_of_one_count_are_in_the_order_of_their_names():
    assert list(counted({"a": "joy", "b": "anger", "c": "", "d": "joy", "e": "fear"})) == ["joy", "anger", "fear"]
    assert shown_emotions({"a": "joy", "b": "anger", "c": "joy"}, EmotionSettings(min_utterances=2)) == ["joy"]


def test_the_figure_is_the_same_for_the_same_figures():
    frame, _, measured = by_emotion(5)
    png = emotion_figure(frame, measured)
    assert png.startswith(b"\x89PNG") and png == emotion_figure(frame, measured)
    assert png != emotion_figure(frame.assign(value=frame["value"] / 2), measured)
