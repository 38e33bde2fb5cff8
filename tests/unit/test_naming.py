"""Names of networks: what is made is read again, and nothing else is."""

import pytest

from visualspeech.errors import SettingError
from visualspeech.naming import NetworkName, cells_of, is_network, parse_name


@pytest.mark.parametrize(
    ("name", "parts"),
    [
        ("FBB-128", NetworkName("FBB", 128)),
        ("F-1-s12", NetworkName("F", 1, seed=12)),
        ("FBB-128-rich", NetworkName("FBB", 128, rich=True)),
        ("BB-64-rich-s0", NetworkName("BB", 64, rich=True, seed=0)),
    ],
)
def test_names_read_back(name, parts):
    assert parse_name(name) == parts and str(parts) == name and is_network(name)


@pytest.mark.parametrize(
    "name", ["hmm_tied", "training_mean", "FBB", "FBB-", "FBB-128-", "FBB-128-s", "FBB-128-s2-rich", ""]
)
def test_other_names_are_no_networks(name):
    assert not is_network(name)
    with pytest.raises(SettingError, match="LETTERS-NODES"):
        parse_name(name)


def test_seeds_share_a_cell():
    names = ["FBB-128", "training_mean", "FFF-128", "FBB-128-s2", "FBB-128-rich", "FBB-128-s3"]
    assert cells_of(names) == {
        "FBB-128": ["FBB-128", "FBB-128-s2", "FBB-128-s3"], "FFF-128": ["FFF-128"], "FBB-128-rich": ["FBB-128-rich"],
    }  # fmt: skip
    assert parse_name("FBB-128-rich-s3").row == "FBB-rich"
