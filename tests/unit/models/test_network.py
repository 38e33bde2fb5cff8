import numpy as np
import pytest
import torch

from tests.unit.models.examples import PHONES, utterances
from visualspeech.errors import DataError, StorageError
from visualspeech.models import baselines
from visualspeech.models.blstm import Stack, StackSettings
from visualspeech.models.network import Network, one_thread


@pytest.fixture
def network():
    torch.manual_seed(1)
    settings = StackSettings("FB", 6)
    weights = {name: values.numpy() for name, values in Stack(settings, len(PHONES), 4).state_dict().items()}
    return Network(settings, PHONES, weights, np.arange(4, dtype=np.float32), 2.5, 25.0, "abc", {"epochs": 3})


def test_the_file_gives_the_same_network(tmp_path, network):
    network.save(tmp_path / "network.safetensors")
    again = Network.load(tmp_path / "network.safetensors")
    labels = utterances(1)[0][0]
    assert np.array_equal(again.predict(labels), network.predict(labels))
    assert (again.phones, again.aam, again.rate, again.outputs, again.about) == (PHONES, "abc", 25.0, 4, {"epochs": 3})
    again.save(tmp_path / "again.safetensors")
    assert (tmp_path / "again.safetensors").read_bytes() == (tmp_path / "network.safetensors").read_bytes()


def test_outputs_are_scaled_back_to_appearance(network):
    labels = utterances(1)[0][0]
    raw = Network(network.stack, PHONES, network.weights, np.zeros(4), 1.0, 25.0).predict(labels)
    assert np.allclose(network.predict(labels), 2.5 * raw + np.arange(4), atol=1e-5)


def test_labels_of_another_inventory_are_refused(network):
    with pytest.raises(DataError, match="inventory of 6 phones"):
        network.predict(np.array([[0, 6, 0, 0]]))
    with pytest.raises(DataError, match="four indices"):
        network.predict(np.zeros((0, 4), int))


def test_files_that_are_no_network(tmp_path):
    path = tmp_path / "mean.safetensors"
    baselines.fit("training_mean", utterances(1), len(PHONES)).save(path)
    with pytest.raises(StorageError, match="mean.safetensors holds no network. Give"):
        Network.load(path)
    path.write_bytes(b"no model")
    with pytest.raises(StorageError):
        Network.load(path)


def test_one_thread_gives_the_threads_back():
    before = torch.get_num_threads()
    with one_thread():
        assert torch.get_num_threads() == 1
    assert torch.get_num_threads() == before
