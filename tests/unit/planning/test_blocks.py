"""Planning of input blocks that are made of others, and of who can speak."""

import pytest

from tests.unit.planning.configs import resolved
from visualspeech.errors import SettingError
from visualspeech.models.rows import ModelRow
from visualspeech.planning.blocks import read_faces, speaking_row
from visualspeech.speech import egemaps

BLOCKS = {
    "dv": {"kind": "dynamic_visemes"},
    "seen": {"kind": "dynamic_visemes", "source": "oracle"},
    "ctx": {"kind": "viseme_context", "visemes": "dv"},
    "seen_ctx": {"kind": "viseme_context", "visemes": "seen"},
}
MODELS = {
    "honest": {"family": "stack", "letters": "F", "nodes": 8, "reads": ["dv", "ctx"]},
    "cheat": {"like": "honest", "reads": ["dv", "seen_ctx"]},
}


def changed(blocks=(), models=(), speak=(), **system):
    own = {"blocks": BLOCKS | dict(blocks), "models": MODELS | dict(models), **system}
    return {"override": {"systems": {"fan2015": own}}, "speak": dict(speak)}


def test_blocks_of_visemes_are_complete_and_need_faces():
    system = resolved(changed())["systems"]["fan2015"]
    assert system["blocks"]["dv"]["settings"]["classes"] == 160
    assert {"text", "faces"} <= set(system["needs"])
    assert system["viseme_numbers"] == {"block": "", "classes": [20, 40, 80, 160, 320]}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (changed({"ctx": {"kind": "viseme_context"}}), r"ctx.visemes: ` is no input block of kind dynamic_visemes"),
        (changed({"ctx": {"kind": "viseme_context", "visemes": "dvs"}}), r"visemes: dvs` is no .*Did you mean `dv`"),
        (changed({"ctx": {"kind": "viseme_context", "visemes": "tri"}}), r"visemes: tri` is no .*Known: dv, seen"),
        (changed({"dv": None}, {"honest": None, "cheat": None}), r"blocks.ctx.visemes: dv` is no .*Known: seen"),
        (changed({"dv": {"kind": "dynamic_visemes", "classes": 1}}), r"dv.classes: 1` must be at least 2"),
        (changed({"dv": {"kind": "dynamic_visemes", "source": "heard"}}), r"heard` must be one of oracle, predicted"),
        (changed({"given": {"kind": "arrays"}}), r"blocks.given.kind: arrays` must be one of dynamic_visemes, full"),
        (changed(viseme_numbers={"block": "tri"}), r"viseme_numbers.block: tri` is no input block of kind dynamic_vis"),
        (changed(viseme_numbers={"classes": [1]}), r"viseme_numbers.classes.0: 1` must be at least 2"),
        (changed(speak={"model": "cheat"}), r"`speak.model: cheat` reads dynamic visemes of the recording "
         r"\(input block seen_ctx, `source: oracle`\), and new text has none; name a model with .* ones: .*honest"),
    ],
)  # fmt: skip
def test_mistakes_are_one_sentence_before_any_job(change, said):
    with pytest.raises(SettingError, match=said) as told:
        resolved(change)
    assert len(str(told.value).splitlines()) == 1


def test_who_reads_recorded_faces():
    blocks = resolved(changed())["systems"]["fan2015"]["blocks"]
    assert read_faces(["tri_shares", "dv", "ctx", "mel"], blocks) == []
    assert read_faces(["dv", "seen", "ctx", "seen_ctx"], blocks) == ["seen", "seen_ctx"]


def test_the_shown_model_speaks_where_it_can_and_else_the_first_that_can():
    system = resolved(changed())["systems"]["fan2015"]
    rows = [ModelRow.of(row) for row in system["rows"]]
    assert speaking_row(rows, system["blocks"], "honest") == "honest"
    first = next(row.name for row in rows if row.role == "model")
    assert speaking_row(rows, system["blocks"], "cheat") == first
    blind = [row for row in rows if row.name == "cheat" or row.role == "floor"]
    assert speaking_row(blind, system["blocks"], "cheat") == ""
    assert resolved(changed(speak={"model": "honest"}))["speak"]["model"] == "honest"


def test_a_block_whose_package_is_missing_is_refused(monkeypatch):
    over = changed({"spoken": {"kind": "speech44"}}, {"heard": {"like": "honest", "reads": ["spoken"]}})
    monkeypatch.setattr(egemaps, "find_spec", lambda name: True)
    assert resolved(over)["systems"]["fan2015"]["blocks"]["spoken"]["settings"]["scaling"] == "speaker"
    monkeypatch.setattr(egemaps, "find_spec", lambda name: None)
    said = (
        r"systems\.fan2015\.blocks\.spoken\.kind: speech44` cannot be computed: the package opensmile is not installed"
    )
    with pytest.raises(SettingError, match=rf"{said}.*pip install -e '\.\[egemaps\]'.*speech27") as refused:
        resolved(over)
    assert "\n" not in str(refused.value)
    assert resolved(changed({"spoken": {"kind": "speech27"}}, {"heard": {"like": "honest", "reads": ["spoken"]}}))
