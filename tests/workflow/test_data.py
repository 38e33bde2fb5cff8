"""docs/data.md describes every file, array, attribute and column of a finished run."""

import shutil

import h5py
import numpy as np
import pandas
import pytest

from tests.described_files import undescribed
from visualspeech.storage.arrays import ArrayWriter
from visualspeech.storage.models import write_model
from visualspeech.storage.tables import write_table

pytestmark = pytest.mark.xdist_group("workflow")


def test_every_file_of_a_run_is_described(tiny_run):
    assert undescribed(tiny_run / "results" / "tiny") == []


def test_what_the_page_lacks_is_found(tiny_run, tmp_path):
    """The test above can fail: each kind of difference is reported with its file."""
    own = tiny_run / "results" / "tiny"
    (tmp_path / "landmarks").mkdir()
    shutil.copy(own / "landmarks" / "0.h5", tmp_path / "landmarks" / "0.h5")
    shutil.copy(own / "mouth.tsv", tmp_path)
    assert undescribed(tmp_path) == []
    with h5py.File(tmp_path / "landmarks" / "0.h5", "a") as file:
        group = next(iter(file.values()))
        group.attrs["lens"] = 50.0
        group["quality"] = np.zeros(3)
    with ArrayWriter(tmp_path / "pose" / "0.h5") as out:
        out.add("a", {"points": np.zeros((4, 68, 2)), "rotation": np.zeros((5, 3))}, 25.0)
        out.add("b", {"points": np.zeros((4, 51, 2)), "translation": np.zeros((4, 3), np.float32)}, 25.0)
    write_table(tmp_path / "phones.tsv", pandas.DataFrame({"phone": ["sil"], "count": [1]}))
    write_model(tmp_path / "heads" / "demo.safetensors", {"points3d": np.zeros((68, 3)), "hair": np.zeros(2)}, {})
    (tmp_path / "notes.txt").write_text("")
    assert undescribed(tmp_path) == [
        "heads/demo.safetensors: the array hair is not described",
        "landmarks/0.h5: the array quality is not described",
        "landmarks/0.h5: the attribute lens is not described",
        "notes.txt: the file is not described",
        "phones.tsv: the column count is not described",
        "pose/0.h5: the array rotation is (5, 3), described as (T, 3)",
        "pose/0.h5: the array points is (4, 51, 2), described as (T, 68, 2)",
        "pose/0.h5: the array translation is float32, described as float64",
    ]
