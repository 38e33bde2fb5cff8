"""Joint and separate networks: the paper's sizes, their outputs, gradients and training, their files."""

import dataclasses
from dataclasses import replace

import numpy as np
import pytest
import torch

from tests.unit.models.examples import BLOCKS, RATE, Values, task, utterances, with_stream
from tests.unit.models.test_gathered import inputs
from tests.unit.models.test_training import Killed, kill_after
from visualspeech.errors import DataError, SettingError, StorageError
from visualspeech.features.streams import Layout, Stream
from visualspeech.models import joint, joint_network
from visualspeech.models import training as module
from visualspeech.models.batches import Scaling, batch
from visualspeech.models.fitting import fit_network
from visualspeech.models.joint_network import Joint, output_columns, weight_shapes
from visualspeech.models.joint_settings import JointSettings, check_regions, parameter_count
from visualspeech.models.objectives import ConcordanceCorrelation, objective_of
from visualspeech.models.registry import expand, load_model
from visualspeech.models.training import one_thread
from visualspeech.models.training_settings import training_settings
from visualspeech.storage.models import read_model, write_model

#: Of six outputs, in no order; networks have them in the order of their names.
REGIONS = {"lower": (5, 1, 3), "middle": (2,), "upper": (4, 0)}
UNSORTED = dict(reversed(REGIONS.items()))
LAYOUTS = [replace(BLOCKS["tri"].layout, window=1), Layout(dimension=2)]
TRAINING, VALIDATION = utterances(16, outputs=6), utterances(5, seed=1, outputs=6)
FAST = {"objective": "ccc", "batcher": "frames", "batch_frames": 120, "max_epochs": 4, "learning_rate": 0.01,
        "dropout": 0.2, "max_grad_norm": 0.0, "ema_decay": 0.0}  # fmt: skip
PAPER = {"upper": range(57), "middle": range(57, 93), "lower": range(93, 138)}


def given(settings=None, options=FAST, regions=UNSORTED, training=TRAINING, validation=VALIDATION, **more):
    settings = {"nodes": 6, **(settings or {})}
    return task("joint", settings, training, validation, options=options, regions=regions, **more)


@pytest.mark.parametrize(
    ("layers", "shared", "nodes", "count"),
    [
        (1, 0, 512, 12_805_770),
        (1, 2, 512, 4_362_890),
        (1, 0, 1024, 50_777_226),
        (1, 2, 1024, 17_114_250),
        (2, 0, 512, 31_692_426),
        (2, 2, 512, 23_249_546),
    ],
)
def test_the_numbers_of_parameters_are_those_of_the_paper(layers, shared, nodes, count):
    # Table 1: 12.8M, 4.4M, 50.8M, 17.1M, 31.7M, 23.2M, for 44 inputs and 19, 12 and 15 markers.
    settings = JointSettings(layers=layers, shared=shared, nodes=nodes)
    plain = {**dataclasses.asdict(settings), "regions": {name: list(one) for name, one in PAPER.items()}}
    assert parameter_count(settings, [Layout(dimension=44)], PAPER) == count
    assert sum(map(np.prod, weight_shapes(plain, [Layout(dimension=44)], 138).values())) == count
    with torch.device("meta"):
        network = Joint(dataclasses.replace(settings, initialisation="torch"), [Layout(dimension=44)], PAPER)
    assert sum(values.numel() for values in network.parameters()) == count


@pytest.mark.parametrize("trajectory", ["none", "mlpg"])
@pytest.mark.parametrize(("layers", "shared"), [(1, 0), (1, 1), (1, 2), (2, 0), (2, 2), (2, 3), (3, 1)])
def test_shapes_and_number_of_the_weights_are_known_without_a_network(layers, shared, trajectory):
    settings = JointSettings(nodes=5, layers=layers, shared=shared, trajectory=trajectory)
    plain = {**dataclasses.asdict(settings), "regions": {name: list(one) for name, one in REGIONS.items()}}
    outputs = 18 if trajectory == "mlpg" else 6
    made = Joint(settings, LAYOUTS, output_columns(REGIONS, settings, outputs))
    shapes = {name: tuple(values.shape) for name, values in made.state_dict().items()}
    assert weight_shapes(plain, LAYOUTS, outputs) == shapes
    assert parameter_count(settings, LAYOUTS, REGIONS) == sum(values.numel() for values in made.parameters())


def slow_lstm(x, weight_ih, weight_hh):
    """An LSTM as Hochreiter and Schmidhuber's with forget gates, frame by frame; the last input column is the bias."""
    sigmoid = lambda value: 1 / (1 + np.exp(-value))  # noqa: E731
    nodes = weight_hh.shape[1]
    hidden, cell, found = np.zeros(nodes), np.zeros(nodes), []
    for row in x:
        gates = weight_ih[:, :-1] @ row + weight_hh @ hidden + weight_ih[:, -1]
        enter, forget, new, leave = np.split(gates, 4)
        cell = sigmoid(forget) * cell + sigmoid(enter) * np.tanh(new)
        hidden = sigmoid(leave) * np.tanh(cell)
        found.append(hidden)
    return np.array(found)


def slow_outputs(weights, x, settings, regions):
    """Outputs (T, N) of one utterance's inputs (T, D), from the weights by name."""

    def through(place, number, hidden):
        own = {name.removeprefix(f"{place}."): value for name, value in weights.items() if name.startswith(f"{place}.")}
        if not number:
            first = np.concatenate([own["classes"].T, own["values"]], axis=1)
            return np.maximum(hidden @ first.T + own["bias"], 0)
        forward = slow_lstm(hidden, own["lstm.weight_ih_l0"], own["lstm.weight_hh_l0"])
        back = slow_lstm(hidden[::-1], own["lstm.weight_ih_l0_reverse"], own["lstm.weight_hh_l0_reverse"])
        return np.concatenate([forward, back[::-1]], axis=1)

    for number in range(settings.shared):
        x = through(f"shared.{number}", number, x)
    result = np.full((len(x), sum(map(len, regions.values()))), np.nan)
    for region, columns in enumerate(regions.values()):
        hidden = x
        for number in range(settings.shared, settings.layers + 1):
            hidden = through(f"regions.{region}.{number - settings.shared}", number, hidden)
        last = f"regions.{region}.{settings.layers + 1 - settings.shared}"
        result[:, list(columns)] = hidden @ weights[f"{last}.weight"].T + weights[f"{last}.bias"]
    return result


def two_streams(number, seed=0):
    """A padded batch in double precision of utterances with classes and two real values, and the utterances."""
    examples = utterances(number, seed=seed, outputs=6)
    generator = np.random.default_rng(seed)
    streams = [Stream(values=generator.normal(size=(len(one.target), 2)).astype(np.float32)) for one in examples]
    examples = with_stream(examples, streams)
    order = np.argsort([-len(one.target) for one in examples], kind="stable")
    whole = batch(examples, order, Scaling(np.zeros(6), np.ones(6)))
    whole = replace(whole, values=whole.values.double(), targets=whole.targets.double())
    return [examples[n] for n in order], whole


@pytest.mark.parametrize(("layers", "shared"), [(1, 0), (1, 2), (2, 0), (2, 2), (2, 1), (1, 1)])
def test_outputs_of_padded_utterances_against_plain_numpy(layers, shared):
    torch.manual_seed(1)
    settings = JointSettings(nodes=4, layers=layers, shared=shared, initialisation="torch")
    network = Joint(settings, LAYOUTS, REGIONS, dropout=0.5).double().eval()
    examples, whole = two_streams(4)
    outputs = network(whole).detach().numpy()
    weights = {name: values.numpy() for name, values in network.state_dict().items()}
    for row, one in enumerate(examples):
        x = inputs(LAYOUTS, one.streams[0].index.astype(np.int64), one.streams[1].values)
        expected = slow_outputs(weights, x, settings, REGIONS)
        np.testing.assert_allclose(outputs[row, : len(x)], expected, rtol=1e-9, atol=1e-12)
        assert not outputs[row, len(x) :].any()


@pytest.mark.parametrize(("layers", "shared"), [(1, 2), (2, 2), (2, 0)])
def test_gradients_of_the_concordance_by_finite_differences(layers, shared):
    torch.manual_seed(2)
    network = Joint(JointSettings(nodes=3, layers=layers, shared=shared), LAYOUTS, REGIONS).double()
    whole, objective = two_streams(2)[1], ConcordanceCorrelation()

    def loss():
        with one_thread():
            return objective.loss(network(whole), whole.targets, whole.lengths)

    loss().backward()
    random = np.random.default_rng(0)
    for name, weights in network.named_parameters():
        for place in random.choice(weights.numel(), min(3, weights.numel()), replace=False):
            flat, sides = weights.data.view(-1), []
            for step in (1e-5, -2e-5):
                flat[place] += step
                sides.append(loss().item())
            flat[place] += 1e-5
            numeric = (sides[0] - sides[1]) / 2e-5
            assert weights.grad.view(-1)[place].item() == pytest.approx(numeric, rel=1e-5, abs=1e-10), name


def test_a_joint_network_is_judged_by_the_mean_over_all_outputs():
    whole, objective = two_streams(3)[1], ConcordanceCorrelation()
    torch.manual_seed(3)
    predicted = Joint(JointSettings(nodes=3), LAYOUTS, REGIONS).double()(whole)
    by_region = [
        objective.loss(predicted[..., list(one)], whole.targets[..., list(one)], whole.lengths).item() * len(one)
        for one in REGIONS.values()
    ]
    assert objective.loss(predicted, whole.targets, whole.lengths).item() == pytest.approx(sum(by_region) / 6)


def test_initial_weights_are_those_of_glorot():
    torch.manual_seed(0)
    network = Joint(JointSettings(nodes=64, layers=2), LAYOUTS, REGIONS)
    first, lstm, second = network.shared[0], network.shared[1].lstm, network.regions[0][0].lstm
    width = sum(layout.width for layout in LAYOUTS)
    cases = [(first.classes, width, 64), (first.values, width, 64), (network.regions[0][1].weight, 128, 3)]
    cases += [(lstm.weight_ih_l0[:, :-1], 64, 256), (lstm.weight_hh_l0_reverse, 64, 256)]
    cases += [(second.weight_ih_l0_reverse[:, :-1], 128, 256)]
    for weights, inside, outside in cases:
        bound = (6 / (inside + outside)) ** 0.5
        assert 0.9 * bound < weights.abs().max() <= bound
        assert weights.std().item() == pytest.approx(bound / 3**0.5, rel=0.1)
    assert not first.bias.any() and not network.regions[2][1].bias.any()
    gates = torch.stack([lstm.weight_ih_l0[:, -1], second.weight_ih_l0_reverse[:, -1]]).reshape(2, 4, 64)
    assert (gates[:, 1] == 1).all() and not gates[:, [0, 2, 3]].any()


def arrays_of(fitted):
    return {name: values.numpy() for name, values in fitted.model.module.state_dict().items()}


@pytest.mark.parametrize("options", [{}, {"objective": "sse", "patience": 1, "max_epochs": 9, "max_grad_norm": 0.1}])
@pytest.mark.parametrize("trajectory", ["none", "mlpg"])
def test_separate_networks_are_those_that_are_trained_alone(options, trajectory):
    settings = {"shared": 0, "layers": 1, "trajectory": trajectory}
    whole = joint.fit(given(settings, {**FAST, **options}))
    lengths = []
    for number, (name, columns) in enumerate(REGIONS.items()):

        def only(examples, columns=columns):
            return [one._replace(target=one.target[:, list(columns)]) for one in examples]

        own = {name: range(len(columns))}
        alone = joint.fit(
            given(settings, {**FAST, **options}, own, training=only(TRAINING), validation=only(VALIDATION))
        )
        for key, values in arrays_of(alone).items():
            np.testing.assert_array_equal(arrays_of(whole)[key.replace("regions.0", f"regions.{number}")], values)
        for one in VALIDATION:
            predicted = alone.model.predict(one.streams)
            np.testing.assert_allclose(
                whole.model.predict(one.streams)[:, list(columns)], predicted, rtol=1e-5, atol=1e-5
            )
        lengths.append(len(alone.curve))
        curve = whole.curve[f"validation_{name}"].to_numpy()
        np.testing.assert_array_equal(curve[: lengths[-1]], alone.curve.validation)
        assert (curve[lengths[-1] :] == alone.curve.validation.min()).all()
    assert len(whole.curve) == max(lengths) and list(whole.curve.epoch) == list(range(1, max(lengths) + 1))
    if trajectory == "none":
        ends = [whole.model.about[name]["best_epoch"] - 1 for name in REGIONS]
        curves = [whole.curve[f"validation_{name}"][end] for name, end in zip(REGIONS, ends, strict=True)]
        total = sum(curves) if options else np.dot(curves, [3, 1, 2]) / 6
        assert error_of({**FAST, **options}["objective"], whole.model) == pytest.approx(total, rel=1e-4)


def error_of(name, model):
    pairs = zip(*((model.predict(one.streams), one.target) for one in VALIDATION), strict=True)
    predicted, true = (torch.tensor(np.concatenate(side)).double()[None] for side in pairs)
    objective, frames = objective_of(training_settings(objective=name)), torch.tensor([true.shape[1]])
    return objective.loss(predicted, true, frames).item() / (frames.item() if objective.additive else 1)


def test_a_network_that_shares_all_hidden_layers_is_one_that_predicts_all_at_once():
    # Joint-1 (section 4.3): the same weights in one linear layer, and the same training.
    settings, order = {"shared": 2, "initialisation": "torch"}, [column for one in REGIONS.values() for column in one]
    joined = joint.fit(given(settings, {**FAST, "initial_std": 0.0}))
    torch.manual_seed(0)
    whole = Joint(JointSettings(nodes=6), LAYOUTS[:1], {"face": range(6)}).eval()
    found = arrays_of(joined)
    state = {name: torch.tensor(values) for name, values in found.items() if name.startswith("shared")}
    for part in ("weight", "bias"):
        rows = np.concatenate([found[f"regions.{region}.0.{part}"] for region in range(3)])
        state[f"regions.0.0.{part}"] = torch.tensor(rows[np.argsort(order)])
    whole = Joint(JointSettings(nodes=6), [BLOCKS["tri"].layout], {"face": range(6)}).eval()
    whole.load_state_dict(state)
    streams = VALIDATION[0].streams
    predicted = replace(joined.model, module=whole).predict(streams)
    np.testing.assert_allclose(predicted, joined.model.predict(streams), rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("objective", ["ccc", "mse"])
@pytest.mark.parametrize("shared", [0, 2])
def test_training_beats_the_training_mean_in_each_region(objective, shared):
    options = {**FAST, "objective": objective, "max_epochs": 30, "learning_rate": 0.02, "scaling": "dimension"}
    model = joint.fit(given({"nodes": 16, "shared": shared}, options)).model
    predicted = np.concatenate([model.predict(one.streams) for one in VALIDATION])
    true = np.concatenate([one.target for one in VALIDATION])
    mean = np.concatenate([one.target for one in TRAINING]).mean(axis=0)
    for columns in map(list, REGIONS.values()):
        x, y = predicted[:, columns], true[:, columns]
        covariance = ((x - x.mean(axis=0)) * (y - y.mean(axis=0))).mean(axis=0)
        concordance = 2 * covariance / (x.var(axis=0) + y.var(axis=0) + (x.mean(axis=0) - y.mean(axis=0)) ** 2)
        assert (concordance > 0.5).all()
        assert np.square(x - y).mean() < 0.7 * np.square(mean[columns] - y).mean()


@pytest.mark.parametrize("shared", [0, 2])
def test_the_same_seed_gives_the_same_weights(shared):
    first, again, other = (
        arrays_of(joint.fit(given({"shared": shared}, {**FAST, "max_epochs": 2}, seed=seed))) for seed in (1, 1, 2)
    )
    assert all(np.array_equal(first[name], again[name]) for name in first)
    assert not any(np.array_equal(first[name], other[name]) for name in first if "bias" not in name)


@pytest.mark.parametrize("killed", [1, 4, 9])
@pytest.mark.parametrize("settings", [{"shared": 2}, {"shared": 0}, {"shared": 0, "learning_rates": [0.02, 0.01]}])
def test_killed_and_resumed_is_as_if_never_killed(tmp_path, monkeypatch, settings, killed):
    options = {**FAST, "max_epochs": 3}
    whole = joint.fit(given(settings, options))
    checkpoint = tmp_path / "checkpoint.safetensors"
    train = module.train
    with monkeypatch.context() as patch:
        patch.setattr("visualspeech.models.fitting.train", lambda *given: train(*given, checkpoint_seconds=0.0))
        with monkeypatch.context() as inner:
            kill_after(killed, inner)
            try:
                joint.fit(given(settings, options, checkpoint=checkpoint))
            except Killed:
                kept = {path: path.read_bytes() for path in tmp_path.iterdir()}
                assert kept
        resumed = joint.fit(given(settings, options, checkpoint=checkpoint))
    for name, values in arrays_of(whole).items():
        np.testing.assert_array_equal(arrays_of(resumed)[name], values)
    names = [name for name in whole.curve if name != "seconds"]
    assert whole.curve[names].equals(resumed.curve[names])


def test_finished_networks_of_a_killed_job_are_not_trained_again(tmp_path, monkeypatch):
    own = given({"shared": 0}, {**FAST, "max_epochs": 2}, checkpoint=tmp_path / "checkpoint.safetensors")
    first = joint.fit(own)
    assert len(list(tmp_path.glob("checkpoint*.safetensors"))) == 3
    with monkeypatch.context() as patch:
        patch.setattr(module, "_epoch", lambda *_: pytest.fail("trained again"))
        again = joint.fit(own)
        assert all(np.array_equal(values, arrays_of(again)[name]) for name, values in arrays_of(first).items())
        with pytest.raises(pytest.fail.Exception):
            joint.fit(replace(own, regions={"lower": (5, 4, 3), "middle": (2,), "upper": (1, 0)}))


def test_a_checkpoint_of_other_regions_is_not_used(tmp_path):
    own = given({}, {**FAST, "max_epochs": 2}, checkpoint=tmp_path / "checkpoint.safetensors")
    joint.fit(own)
    other = replace(own, regions={"upper": (0, 4), "middle": (2,), "lower": (5, 1, 3)})
    assert np.array_equal(
        joint.fit(other).model.predict(VALIDATION[0].streams),
        joint.fit(replace(other, checkpoint=None)).model.predict(VALIDATION[0].streams),
    )


@pytest.mark.parametrize("shared", [0, 2])
def test_the_search_keeps_the_learning_rate_with_the_lowest_validation_error(shared):
    rates, options = [1e-5, 0.02, 1e-3], {**FAST, "max_epochs": 4, "learning_rate": 0.5}
    found = joint.fit(given({"shared": shared, "learning_rates": rates}, options))
    alone = [joint.fit(given({"shared": shared}, {**options, "learning_rate": rate})) for rate in rates]
    errors = [one.curve.validation.min() for one in alone]
    assert np.argmin(errors) == 1
    for name, values in arrays_of(found).items():
        np.testing.assert_array_equal(values, arrays_of(alone[1])[name])
    about = found.model.about if shared else found.model.about["lower"]
    assert list(about["learning_rates"]) == ["1e-05", "0.02", "0.001"]
    if shared:
        assert list(about["learning_rates"].values()) == pytest.approx(errors)
        assert about["training"]["learning_rate"] == 0.02


def test_a_learning_rate_that_diverges_is_not_chosen(monkeypatch, caplog):
    def failing(task, family, settings, training, *more):
        if training.learning_rate > 0.05:
            raise SettingError("the training of x diverged")
        return fit_network(task, family, settings, training, *more)

    monkeypatch.setattr(joint, "fit_network", failing)
    options = {**FAST, "max_epochs": 1}
    found = joint.fit(given({"learning_rates": [0.1, 0.01]}, options))
    assert list(found.model.about["learning_rates"]) == ["0.01"] and "diverged" in caplog.text
    with pytest.raises(SettingError, match="diverged"):
        joint.fit(given({"learning_rates": [0.1, 0.2]}, options))


@pytest.mark.parametrize("trajectory", ["none", "mlpg"])
@pytest.mark.parametrize(("layers", "shared"), [(1, 0), (1, 2), (2, 0), (2, 2)])
def test_through_a_file(tmp_path, layers, shared, trajectory):
    settings = {"layers": layers, "shared": shared, "trajectory": trajectory, "learning_rates": [0.01]}
    own = given(settings, {**FAST, "max_epochs": 2}, coding="abc")
    own = replace(own, row=replace(own.row, windows={"tri": 0.04}))
    model = joint.fit(own).model
    path = tmp_path / "model.safetensors"
    model.save(path)
    again = load_model(path)
    assert (again.outputs, again.rate, again.coding, again.windows) == (6, RATE, "abc", {"tri": 0.04})
    assert again.settings["regions"] == {name: list(one) for name, one in REGIONS.items()}
    for one in VALIDATION:
        np.testing.assert_array_equal(again.predict(one.streams), model.predict(one.streams))
    again.save(tmp_path / "again.safetensors")
    assert (tmp_path / "again.safetensors").read_bytes() == path.read_bytes()
    names = [name for name in read_model(path)[0] if name.startswith("weights.")]
    assert not any(name.startswith("weights.shared") and "bias" in name and ".0." not in name for name in names)
    saved = sum(read_model(path)[0][name].size for name in names)
    layouts = [replace(BLOCKS["tri"].layout, window=1)]
    assert saved == parameter_count(JointSettings(**{"nodes": 6, **settings}), layouts, REGIONS)


def changed(plain, **own):
    return {**plain, "settings": {**plain["settings"], **own}}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda s: changed(s, nodes=4096), "of the weights"),
        (lambda s: changed(s, nodes=10**9), "must be at least 1 and at most 4096"),
        (lambda s: changed(s, layers=3), "of the weights"),
        (lambda s: changed(s, layers=10**9), "must be at least 1 and at most 4"),
        (lambda s: changed(s, shared=0), "of the weights"),
        (lambda s: changed(s, shared=4), "must be at most 2 with `layers: 1`"),
        (lambda s: changed(s, regions=None), "the regions are no lists of columns by name"),
        (lambda s: changed(s, regions={"upper": 3}), "the regions are no lists of columns by name"),
        (lambda s: changed(s, regions=[[0, 1, 2, 3, 4, 5]]), "the regions are no lists of columns by name"),
        (lambda s: changed(s, regions={}), "the regions do not hold each of 6 outputs once"),
        (lambda s: changed(s, regions={"face": [0, 1, 2, 3, 4, 4]}), "the regions do not hold each of 6 outputs once"),
        (lambda s: changed(s, regions={"face": [0, 1, 2, 3, 4, 10**9]}), "do not hold each of 6 outputs once"),
        (lambda s: changed(s, regions={"face": [0, 1, 2, 3, 4, 5.0]}), "or they are no whole numbers"),
        (lambda s: changed(s, regions={"face": [0, True, 2, 3, 4, 5]}), "or they are no whole numbers"),
        (lambda s: changed(s, regions={"upper": [0, 1, 2, 3, 4, 5], "lower": []}), "a region has no columns"),
        (lambda s: changed(s, regions={"face": [0, 1, 2, 3, 4, 5]}), "of the weights, regions"),
        (lambda s: changed(s, trajectory="mlpg"), "the regions do not hold each of 2 outputs once"),
        (lambda s: changed(s, more=1), "unexpected keyword argument 'more'"),
    ],
)  # fmt: skip
def test_altered_files_are_refused_before_a_network_is_made(tmp_path, monkeypatch, change, said):
    path = tmp_path / "model.safetensors"
    joint.fit(given({}, {**FAST, "max_epochs": 1})).model.save(path)
    arrays, settings = read_model(path)
    write_model(path, arrays, change(settings))
    for place in (joint, joint_network):
        monkeypatch.setattr(place, "Joint", None)
    with pytest.raises(StorageError, match=said) as found:
        load_model(path)
    assert "model.safetensors" in str(found.value)


def test_hidden_values_are_dropped_in_training_alone():
    network, whole = Joint(JointSettings(nodes=32), LAYOUTS, REGIONS, dropout=0.5).double(), two_streams(1)[1]
    assert not torch.equal(network(whole), network(whole))
    network.eval()
    assert torch.equal(network(whole), network(whole))


def test_real_values_alone_and_an_utterance_of_one_frame():
    examples = [
        one._replace(streams=(Stream(values=np.eye(len(one.target), 3, dtype=np.float32)),))
        for one in [*TRAINING, TRAINING[0]._replace(target=TRAINING[0].target[:1])]
    ]
    for shared in (0, 1, 2):
        own = given({"shared": shared}, {**FAST, "max_epochs": 2}, training=examples, validation=examples[:2])
        model = joint.fit(replace(own, blocks={"dense": Values(3)})).model
        assert model.predict([Stream(values=np.ones((1, 3), np.float32))]).shape == (1, 6)


@pytest.mark.parametrize(
    ("regions", "said"),
    [
        ({"upper": (0, 1), "lower": (3, 4, 5)}, "the regions do not hold each of 6 outputs once"),
        ({"upper": (0, 1), "lower": (1, 2, 3, 4, 5)}, "the regions do not hold each of 6 outputs once"),
    ],
)
def test_regions_that_do_not_fit_the_targets(regions, said):
    with pytest.raises(DataError, match=said):
        joint.fit(given(regions=regions))


def test_a_coding_without_regions_and_lips_of_separate_networks_are_mistakes():
    with pytest.raises(SettingError, match="`models.model.family: joint` predicts regions of the face"):
        joint.fit(given(regions={}))
    with pytest.raises(SettingError, match="`closure_weight` and `open_weight` must be 0"):
        joint.fit(given({"shared": 0}, {**FAST, "objective": "sse", "open_weight": 1.0}))


def test_no_utterances():
    with pytest.raises(DataError, match="there is no training utterance"):
        joint.fit(given(training=[]))


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"shared": 3}, "`models.shared: 3` must be at most 2 with `layers: 1`"),
        ({"shared": 6}, "`models.shared: 6` must be at least 0 and at most 5"),
        ({"layers": 0}, "`models.layers: 0` must be at least 1 and at most 4"),
        ({"initialisation": "he"}, "`models.initialisation: he` must be one of glorot, torch"),
        ({"learning_rates": (0.0,)}, "`models.learning_rates: .*a list in which every entry is above 0"),
    ],
)
def test_settings_out_of_bounds(settings, said):
    with pytest.raises(SettingError, match=said):
        JointSettings(**settings)


def test_rows_of_the_paper_come_in_the_order_of_its_table():
    models = {
        "one": {"family": "joint", "reads": ["speech"], "nodes": [512, 1024], "shared": [0, 2]},
        "two": {"family": "joint", "reads": ["speech"], "layers": [2], "nodes": 512, "shared": [0, 2, 3]},
    }
    rows = [row for row in expand(models, ["speech"], {}, [1], "models") if row.family == "joint"]
    assert [row.name for row in rows] == [
        "Separate-1-512", "Joint-1-512", "Separate-1-1024", "Joint-1-1024", "Separate-2-512", "Joint-2-512",
        "Joint-2-512-shared3",
    ]  # fmt: skip
    assert {row.settings["initialisation"] for row in rows} == {"glorot"}


def test_a_combination_of_lists_that_does_not_go_together():
    models = {"one": {"family": "joint", "reads": ["speech"], "layers": [1, 2], "shared": [2, 3]}}
    with pytest.raises(SettingError, match="`models.one.shared.1: 3` must be at most 2 with `layers: 1`"):
        expand(models, ["speech"], {}, [1], "models")


def test_regions_hold_each_output_once():
    check_regions(REGIONS, 6)
    with pytest.raises(ValueError, match="each of 7 outputs"):
        check_regions(REGIONS, 7)
    with pytest.raises(ValueError, match="5 outputs are no static"):
        output_columns(REGIONS, JointSettings(trajectory="mlpg"), 5)
