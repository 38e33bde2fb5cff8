from dataclasses import asdict, replace

import numpy as np
import pytest
import torch

from tests.unit.models.examples import BLOCKS, RATE, task, utterances
from visualspeech.errors import DataError, StorageError
from visualspeech.features.streams import Stream
from visualspeech.models import mean, stack
from visualspeech.models.batches import Scaling
from visualspeech.models.network import Network
from visualspeech.models.registry import load_model
from visualspeech.models.stack import Stack
from visualspeech.models.stack_settings import StackSettings
from visualspeech.models.training import one_thread
from visualspeech.storage.models import read_model, write_model

STREAMS = utterances(1)[0].streams


@pytest.fixture
def network():
    torch.manual_seed(1)
    settings = StackSettings("FB", 6)
    module = Stack(settings, [BLOCKS["tri"].layout], 4)
    scaling = Scaling(np.arange(4, dtype=np.float32), np.array([2.5, 1, 3, 0.5], np.float32))
    return Network("stack", asdict(settings), module, scaling, BLOCKS, RATE, "abc", {"epochs": 3})


def test_the_file_gives_the_same_network(tmp_path, network):
    network.save(tmp_path / "network.safetensors")
    again = load_model(tmp_path / "network.safetensors")
    assert np.array_equal(again.predict(STREAMS), network.predict(STREAMS))
    assert (again.blocks, again.coding, again.rate, again.outputs) == (BLOCKS, "abc", RATE, 4)
    assert (again.settings, again.about) == (network.settings, {"epochs": 3})
    again.save(tmp_path / "again.safetensors")
    assert (tmp_path / "again.safetensors").read_bytes() == (tmp_path / "network.safetensors").read_bytes()


def test_outputs_are_scaled_back_to_appearance(network):
    raw = replace(network, scaling=Scaling(np.zeros(4), np.ones(4))).predict(STREAMS)
    found = network.predict(STREAMS)
    assert np.allclose(found, network.scaling.scale * raw + np.arange(4), atol=1e-5) and found.dtype == np.float32


def test_streams_of_other_blocks_are_refused(network):
    with pytest.raises(DataError, match=r"`tri`: a class is outside its inventory \(6, 6, 6, 3 classes\)"):
        network.predict([Stream(index=np.array([[0, 6, 0, 0]]))])
    with pytest.raises(DataError, match="`tri`: a stream has no frame"):
        network.predict([Stream(index=np.zeros((0, 4), int))])
    with pytest.raises(DataError, match="`tri`: a stream has 5 categorical and 0 real-valued columns"):
        network.predict([Stream(index=np.zeros((2, 5), int))])
    with pytest.raises(DataError, match="2 input streams given, the model reads 1: tri"):
        network.predict([*STREAMS, *STREAMS])


def test_files_that_are_no_network(tmp_path, network):
    path = tmp_path / "mean.safetensors"
    mean.fit(task("mean", training=utterances(1))).model.save(path)
    with pytest.raises(StorageError, match="mean.safetensors: it holds no model of the family stack. Give"):
        stack.load(path)
    path.write_bytes(b"no model")
    for load in (stack.load, load_model):
        with pytest.raises(StorageError):
            load(path)
    network.save(path)
    arrays, settings = read_model(path)
    write_model(path, arrays, {**settings, "family": "stork"})
    with pytest.raises(StorageError, match="unknown family 'stork'"):
        load_model(path)


@pytest.mark.parametrize("change", [{"weights.output.bias": np.zeros(3, np.float32)}, {"weights.more": np.zeros(1)}])
def test_weights_that_do_not_fit_their_settings_are_a_sentence(tmp_path, network, change):
    path = tmp_path / "network.safetensors"
    network.save(path)
    arrays, settings = read_model(path)
    write_model(path, {**arrays, **change}, settings)
    with pytest.raises(StorageError, match="network.safetensors"):
        stack.load(path)


def test_settings_do_not_decide_how_much_memory_is_used(tmp_path, network, monkeypatch):
    path = tmp_path / "network.safetensors"
    network.save(path)
    arrays, settings = read_model(path)
    huge = {**settings["settings"], "letters": "B" * 16, "nodes": 4096}  # 10 GB of weights
    write_model(path, arrays, {**settings, "settings": huge})
    monkeypatch.setattr(stack, "Stack", None)
    with pytest.raises(StorageError, match="network.safetensors: its weights do not fit its settings"):
        stack.load(path)


def test_one_thread_gives_the_threads_back():
    before = torch.get_num_threads()
    with one_thread():
        assert torch.get_num_threads() == 1
    assert torch.get_num_threads() == before
