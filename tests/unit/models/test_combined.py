"""Ensembles and global-variance compensation: what they predict, and their files, which hold finished models."""

from dataclasses import replace

import numpy as np
import pytest

from tests.unit.models.examples import BLOCKS, PHONES, RATE, Values, task, utterances, with_stream
from visualspeech.errors import DataError, StorageError
from visualspeech.features.blocks.label_parts import LabelParts
from visualspeech.features.blocks.triphone_state import TriphoneState
from visualspeech.features.streams import Stream
from visualspeech.models import ensemble, gv_compensation, lookup, stack
from visualspeech.models.combined_settings import MAX_DEPTH
from visualspeech.models.gv_compensation import compensation, within_deviation
from visualspeech.models.members import blocks_of, check_alike, read_member
from visualspeech.models.registry import load_model
from visualspeech.storage.models import read_model, write_model

PARTS = LabelParts(("position_in_word",))
BOTH = {**BLOCKS, "parts": PARTS}
TRAINING, VALIDATION, TEST = utterances(10), utterances(4, 5), utterances(3, 7)


def with_parts(examples):
    """The same utterances with a stream of the block ``parts``."""
    size = PARTS.layout.sizes[0]
    return with_stream(examples, [Stream(index=(np.arange(len(one.target)) % size)[:, None]) for one in examples])


@pytest.fixture(scope="module")
def paths(tmp_path_factory):
    """Files of a network of two blocks, which it reads in the other order, and of a look-up of one."""
    folder = tmp_path_factory.mktemp("members")
    options = {"max_epochs": 2}
    swapped = {"parts": PARTS, **BLOCKS}
    given = [[one._replace(streams=one.streams[::-1]) for one in with_parts(part)] for part in (TRAINING, VALIDATION)]
    made = {
        "net": stack.fit(task("stack", {"letters": "CB", "nodes": 4}, *given, swapped, options, coding="abc")),
        "lookup": lookup.fit(task("lookup", {}, TRAINING, VALIDATION, coding="abc")),
    }
    for name, fitted in made.items():
        fitted.model.save(folder / f"{name}.safetensors")
    return {name: folder / f"{name}.safetensors" for name in made}


def mixed(paths, *names, blocks=BOTH):
    return ensemble.fit(task("ensemble", blocks=blocks, parents=[paths[name] for name in names]))


def test_the_mean_of_members_each_with_its_own_streams(paths):
    model = mixed(paths, "lookup", "net").model
    assert (list(model.blocks), model.rate, model.outputs, model.coding) == (["tri", "parts"], RATE, 4, "abc")
    for one in with_parts(TEST):
        tri, parts = one.streams
        expected = (
            load_model(paths["lookup"]).predict([tri]).astype(float)
            + load_model(paths["net"]).predict([parts, tri]).astype(float)
        ) / 2
        found = model.predict(one.streams, len(one.target), RATE)
        np.testing.assert_allclose(found, expected, rtol=1e-6)
        assert found.dtype == np.float32


def test_an_ensemble_of_one_is_that_model_and_members_may_be_ensembles(paths, tmp_path):
    mixed(paths, "lookup", blocks=BLOCKS).model.save(tmp_path / "one.safetensors")
    one, streams = load_model(tmp_path / "one.safetensors"), with_parts(TEST)[0].streams
    np.testing.assert_array_equal(one.predict(streams[:1], 9, RATE), load_model(paths["lookup"]).predict(streams[:1]))
    nested = mixed({**paths, "one": tmp_path / "one.safetensors"}, "one", "net").model
    flat = mixed(paths, "lookup", "net").model
    np.testing.assert_array_equal(nested.predict(streams, 9, RATE), flat.predict(streams, 9, RATE))


def test_one_file_holds_all_members(paths, tmp_path):
    model = mixed(paths, "net", "lookup", blocks={"parts": PARTS, **BLOCKS}).model
    model.save(tmp_path / "model.safetensors")
    arrays, settings = read_model(tmp_path / "model.safetensors")
    assert {name.split(".")[1] for name in arrays} == {"0", "1"} and all(name.startswith("members.") for name in arrays)
    assert [one["family"] for one in settings["members"]] == ["stack", "lookup"]
    again, streams = load_model(tmp_path / "model.safetensors"), with_parts(TEST)[0].streams[::-1]
    np.testing.assert_array_equal(again.predict(streams, 9, RATE), model.predict(streams, 9, RATE))
    again.save(tmp_path / "again.safetensors")
    assert (tmp_path / "again.safetensors").read_bytes() == (tmp_path / "model.safetensors").read_bytes()


def test_streams_of_other_blocks_are_refused(paths):
    model = mixed(paths, "lookup", "net").model
    with pytest.raises(DataError, match="1 input streams given, the model reads 2: tri, parts"):
        model.predict(TEST[0].streams, 9, RATE)


def test_members_that_do_not_fit_each_other(paths, tmp_path):
    one = load_model(paths["lookup"])
    for change, said in (
        ({"rate": 50.0}, r"frame rates \(25.0, 50.0\)"),
        ({"coding": "x"}, r"visual codings \(abc, x\)"),
        ({"mean": np.zeros(3)}, r"numbers of parameters \(3, 4\)"),
        ({"blocks": {"tri": TriphoneState((*PHONES, "f"))}}, "different input blocks named tri"),
    ):
        with pytest.raises(DataError, match=said):
            check_alike([one, replace(one, **change)])
    replace(one, coding="x").save(tmp_path / "x.safetensors")
    with pytest.raises(
        DataError, match="the members of `models.mix` do not fit each other: they have different visual"
    ):
        given = task("ensemble", blocks=BLOCKS, parents=[paths["lookup"], tmp_path / "x.safetensors"])
        ensemble.fit(replace(given, row=replace(given.row, group="mix")))


def test_a_row_that_reads_other_blocks_than_its_members(paths):
    with pytest.raises(DataError, match="read tri, parts, not tri"):
        mixed(paths, "lookup", "net", blocks=BLOCKS)
    with pytest.raises(DataError, match="reads tri, not tri, parts"):
        gv_compensation.fit(task("gv_compensation", {}, TRAINING, VALIDATION, BOTH, parents=[paths["lookup"]]))
    for module, key in ((ensemble, "members"), (gv_compensation, "from")):
        with pytest.raises(DataError, match=f"{key}` names no model"):
            module.fit(task(module.FAMILY, {}, TRAINING, VALIDATION))


def test_blocks_come_in_the_order_in_which_they_are_read_first():
    class One:
        def __init__(self, *names):
            self.blocks = {name: Values(1) for name in names}

    assert list(blocks_of([One("a", "b"), One("c", "a"), One("d", "b")])) == ["a", "b", "c", "d"]


def compensated(paths, strength):
    settings = {"strength": strength}
    return gv_compensation.fit(
        task("gv_compensation", settings, TRAINING, VALIDATION, BLOCKS, parents=[paths["lookup"]])
    )


def deviations(model, examples):
    """Recorded and predicted deviations about the mean of each utterance, frame by frame."""
    recorded, predicted = [], []
    for one in examples:
        found = model.predict(one.streams, len(one.target), one.rate).astype(float)
        recorded += list(one.target - one.target.mean(axis=0, dtype=float))
        predicted += list(found - found.mean(axis=0))
    return [np.sqrt(np.mean(np.square(part), axis=0)) for part in (recorded, predicted)]


@pytest.mark.parametrize("strength", [0.0, 0.5, 1.0])
def test_excursions_grow_by_a_power_of_what_they_lack(paths, strength):
    parent, model = load_model(paths["lookup"]), compensated(paths, strength).model
    recorded, before = deviations(parent, TRAINING)
    assert (before < 0.95 * recorded).any()
    np.testing.assert_allclose(model.factor, (recorded / before) ** strength, rtol=1e-5)
    np.testing.assert_allclose(deviations(model, TRAINING)[1], before ** (1 - strength) * recorded**strength, rtol=1e-5)
    for one in TEST:
        plain, found = (each.predict(one.streams, len(one.target), RATE) for each in (parent, model))
        np.testing.assert_allclose(found.mean(axis=0), plain.mean(axis=0), atol=1e-4)
        np.testing.assert_allclose(found - found.mean(axis=0), model.factor * (plain - plain.mean(axis=0)), atol=1e-3)


def test_the_table_says_how_much_was_missing(paths):
    fitted = compensated(paths, 1.0)
    table = fitted.curve.set_index("figure")["value"]
    recorded, before = deviations(load_model(paths["lookup"]), TRAINING)
    assert table["deviation_ratio"] == pytest.approx(np.sqrt((before**2).sum() / (recorded**2).sum()))
    assert table["largest_factor"] == pytest.approx(fitted.model.factor.max())


def test_parameters_that_are_hardly_predicted_are_left_alone():
    recorded, predicted = np.array([2.0, 1.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0, 1e-5])
    np.testing.assert_array_equal(compensation(recorded, predicted, 1.0), [2, 1, 1, 1])
    np.testing.assert_array_equal(compensation(recorded, predicted, 0.0), [1, 1, 1, 1])


def test_deviations_are_about_the_mean_of_each_utterance():
    one = np.array([[1.0, 5.0], [3.0, 5.0]])
    np.testing.assert_allclose(within_deviation([one, one + 100, np.zeros((1, 2))]), [np.sqrt(4 / 5), 0])


def test_the_file_of_a_compensation_holds_its_model(paths, tmp_path):
    model, streams = compensated(paths, 0.5).model, TEST[0].streams
    model.save(tmp_path / "model.safetensors")
    again = load_model(tmp_path / "model.safetensors")
    np.testing.assert_array_equal(again.predict(streams, 9, RATE), model.predict(streams, 9, RATE))
    assert (again.settings.strength, again.rate, again.coding, again.outputs) == (0.5, RATE, "abc", 4)
    again.save(tmp_path / "again.safetensors")
    assert (tmp_path / "again.safetensors").read_bytes() == (tmp_path / "model.safetensors").read_bytes()


def nested(settings, depth):
    """Settings of an ensemble of an ensemble, ``depth`` levels with the model in it."""
    for _ in range(depth - 1):
        settings = {"kind": "model", "family": "ensemble", "members": [settings]}
    return settings


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda a, s: (a, {**s, "members": []}), "members.* should be non-empty"),
        (lambda a, s: (a, {**s, "members": [3]}), "members.0"),
        (lambda a, s: (a, {**s, "members": [s["members"][0]]}), "its members and their arrays do not fit each other"),
        (lambda a, s: (a, {**s, "members": [*s["members"], s["members"][0]]}), "is missing"),
        (lambda a, s: (a, {**s, "members": s["members"][::-1]}), "is unknown|is missing"),
        (lambda a, s: (a, {**s, "members": [{"kind": "aam"}, s["members"][1]]}), "it holds no trained model"),
        (lambda a, s: (a, {**s, "members": [{"kind": "model", "family": "x"}] * 2}), "unknown family 'x'"),
        (lambda a, s: (a, {**s, "members": [{**one, "rate": n + 9.0} for n, one in enumerate(s["members"])]}),
         "its members do not fit each other: they have different frame rates"),
        (lambda a, s: ({**a, "more": a["members.0.mean"]}, s), "'more' is unknown"),
        (lambda a, s: ({**a, "members.0.more": a["members.0.mean"]}, s), "'more' is unknown"),
        (lambda a, s: ({**a, "members.0.mean": np.full(4, np.nan)}, s), "'mean' has a value"),
        (lambda a, s: (a, {**s, "rate": 25.0}), "rate"),
        (lambda a, s: (a, nested(s["members"][0], MAX_DEPTH + 1)), f"more than {MAX_DEPTH} deep"),
        (lambda a, s: (a, nested(s["members"][0], 60)), "deep"),
    ],
)  # fmt: skip
def test_files_that_are_no_ensemble(paths, tmp_path, change, said):
    path = tmp_path / "model.safetensors"
    mixed(paths, "lookup", "net").model.save(path)
    write_model(path, *change(*read_model(path)))
    with pytest.raises(StorageError, match=said):
        load_model(path)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda a, s: ({**a, "factor": np.ones(3)}, s), "it has 3 factors for 4 parameters"),
        (lambda a, s: ({**a, "factor": -np.ones(4)}, s), "'factor' has a value"),
        (lambda a, s: ({k: v for k, v in a.items() if k != "factor"}, s), "'factor' is missing"),
        (lambda a, s: (a, {**s, "members": s["members"] * 2}), "members"),
        (lambda a, s: (a, {**s, "settings": {"strength": 2}}), "strength"),
        (lambda a, s: (a, {**s, "settings": {"more": 2}}), "more"),
    ],
)  # fmt: skip
def test_files_that_are_no_compensation(paths, tmp_path, change, said):
    path = tmp_path / "model.safetensors"
    compensated(paths, 0.5).model.save(path)
    write_model(path, *change(*read_model(path)))
    with pytest.raises(StorageError, match=said):
        load_model(path)


def test_a_member_that_is_no_model_is_named(tmp_path):
    (tmp_path / "net.safetensors").write_bytes(b"no model")
    with pytest.raises(StorageError, match="net.safetensors"):
        read_member(tmp_path / "net.safetensors")
