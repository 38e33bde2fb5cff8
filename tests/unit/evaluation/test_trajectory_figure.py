"""The figure of one parameter: which utterance it shows, and mistakes as sentences."""

import numpy as np
import pytest

from tests.unit.speech.alignments import even_alignment
from visualspeech.corpora.records import Utterance
from visualspeech.errors import DataError
from visualspeech.evaluation import plots
from visualspeech.evaluation.trajectory_figure import parameter_figure
from visualspeech.speech.alignment import to_table
from visualspeech.storage.arrays import ArrayCollection, ArrayWriter
from visualspeech.storage.tables import write_table

UTTERANCES = [Utterance(name, "s", f"{name}.mp4", f"words of {name}", split)
              for name, split in (("a", "train"), ("b", "test"), ("c", "test"))]  # fmt: skip


@pytest.fixture
def drawn(tmp_path, monkeypatch):
    """A function that draws the figure, and what was drawn."""
    generator = np.random.default_rng(1)
    values = {name: generator.normal(size=(40, 6)) for name in "abc"}
    for path, scale in (("targets", 1.0), ("model", 0.5)):
        with ArrayWriter(tmp_path / f"{path}.h5") as out:
            for name, one in values.items():
                out.add(name, {"appearance": scale * one}, 100.0)
    spoken = {name: even_alignment([("sil", ["sil"]), (name, ["ah", "b"])], 0.4) for name in "abc"}
    write_table(tmp_path / "0.tsv", to_table(spoken))
    shown = []
    original = plots.parameter
    monkeypatch.setattr(
        plots, "parameter", lambda *given, **more: shown.append((*given, more)) or original(*given, **more)
    )

    def draw(utterance="", number=5):
        with ArrayCollection([str(tmp_path / "targets.h5")]) as targets:
            predictions = {"with window": str(tmp_path / "model.h5")}
            return parameter_figure(UTTERANCES, utterance, targets, predictions, [str(tmp_path / "0.tsv")], number)

    return draw, shown, values


def test_the_first_test_utterance_is_shown_with_its_own_phones(drawn):
    draw, shown, values = drawn
    assert draw().startswith(b"\x89PNG")
    true, predicted, rate, phones, number, more = shown[0]
    np.testing.assert_array_equal(true, values["b"])
    np.testing.assert_array_equal(predicted["with window"], 0.5 * values["b"])
    assert (rate, number, more["title"]) == (100.0, 5, "b: words of b")
    assert [label for label, _, _ in phones] == ["sil", "ah", "b"]
    draw("c")
    assert shown[1][-1]["title"] == "c: words of c"


def test_what_there_is_not_is_a_sentence(drawn):
    draw, _, _ = drawn
    with pytest.raises(DataError, match="`trajectories.utterance: a` is no test utterance. Test utterances: b, c"):
        draw("a")
    with pytest.raises(DataError, match="there is no parameter 7; the visual coding has 6"):
        draw(number=7)
