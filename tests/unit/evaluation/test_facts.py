"""The header of a table: what it names, from what."""

import numpy as np

from tests.unit.evaluation.examples import measured, stack, statistics
from visualspeech import __version__
from visualspeech.evaluation.facts import TableFacts, coding_sizes
from visualspeech.provenance import split_hash
from visualspeech.storage.models import read_shapes, write_model

GIVEN = {"corpus": "demo", "system": "fan2015", "coding": "aam51", "drift": "clip_mean"}
SHAPES = {
    "appearance_components": (87, 166),
    "shape_components": (66, 102),
    "texture_components": (100, 9),
    "totals": (3,),
}


def rows(*seeds, rate=25.0):
    table = statistics([1.0, 2.0], rate=rate)
    return measured(("training_mean", table), *((stack(f"F-{seed}", "F", 8, seed), table) for seed in seeds))


def test_everything_that_a_figure_rests_on_is_named():
    split = {"u0": "test", "u1": "train"}
    facts = TableFacts.of(GIVEN, split, SHAPES, rows(3, 2))
    assert dict(facts.lines(rows(3, 2))) == {
        "corpus": "demo",
        "system": "fan2015",
        "split": split_hash(split),
        "rate": "25 Hz",
        "visual coding": "aam51 (66 shape, 100 texture, 87 appearance)",
        "drift removal": "clip_mean",
        "seeds": "2, 3",
        "test utterances": "2",
        "test frames": "41",
        "visualspeech": __version__,
    }


def test_several_rates_are_a_range_and_what_is_unknown_is_left_out():
    facts = TableFacts.of(GIVEN | {"drift": ""}, {}, {}, rows(rate=[25.0, 29.97]))
    lines = dict(facts.lines(rows()))
    assert lines["rate"] == "25–29.97 Hz" and lines["visual coding"] == "aam51"
    assert "drift removal" not in lines and "seeds" not in lines


def test_sizes_of_a_coding_are_read_from_the_header_of_its_file(tmp_path):
    path = tmp_path / "model.safetensors"
    tensors = {
        "shape_components": np.zeros((5, 8), np.float32),
        "markers_components": np.zeros((2, 8)),
        "mean": np.ones(3),
    }
    write_model(path, tensors, {})
    assert read_shapes(path) == {"markers_components": (2, 8), "mean": (3,), "shape_components": (5, 8)}
    assert coding_sizes(read_shapes(path)) == "5 shape, 2 markers"
    assert coding_sizes({"mean": (3, 138), "deviation": (3, 138)}) == "138 coordinates"
