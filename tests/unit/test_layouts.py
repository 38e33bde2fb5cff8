"""Layouts of files: what they let through, and the sentence about everything else."""

import numpy as np
import pytest

from visualspeech.errors import DamagedFile
from visualspeech.storage.layouts import PHONES, Array, FileLayout, check_arrays, check_plain, parse_plain

LAYOUT = FileLayout(
    {
        "mean": Array("f", ("N",), -5, 5),
        "texture": Array("f", ("2N", "M?")),
        "index": Array("iu", (3,), 0, 7),
        "weights.*": Array("f", None),
    },
    {"rate": {"type": "number", "maximum": 9}},
)
GOOD = {
    "mean": np.ones(2),
    "texture": np.zeros((4, 0), np.float32),
    "index": np.arange(3),
    "weights.a": np.zeros((2, 2)),
}


def test_what_fits_passes_and_sizes_are_returned():
    assert LAYOUT.check("f", GOOD, {"rate": 2}) == {"N": 2, "M?": 0}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"mean": np.ones(3)}, r"'texture' has the shape \(4, 0\), not \(6, M\?\)"),
        ({"mean": np.ones(0)}, "'mean' has the shape"),
        ({"mean": np.array([1.0, np.nan])}, "'mean' has a value that is no number from -5 to 5"),
        ({"mean": np.array([1.0, -np.inf])}, "'mean' has a value"),
        ({"mean": np.array([1.0, 5.1])}, "'mean' has a value"),
        ({"texture": np.full((4, 2), 1e308)}, "'texture' has a value"),
        ({"mean": np.ones(2, np.float16)}, "'mean' is of the type float16"),
        ({"mean": np.ones(2, int)}, "'mean' is of the type int64"),
        ({"index": np.array([0, 1, 8])}, "'index' has a value"),
        ({"index": np.zeros((3, 1), int)}, "'index' has the shape"),
        ({"weights.b": np.ones((0, 2))}, "'weights.b' has the shape"),
        ({"other": np.ones(2)}, "'other' is unknown"),
    ],
)
def test_what_does_not_fit_is_named(change, said):
    with pytest.raises(DamagedFile, match=f"cannot read file.x: the array {said}"):
        LAYOUT.check("file.x", GOOD | change, {"rate": 2})


def test_a_missing_array_and_sizes_that_are_known_beforehand():
    with pytest.raises(DamagedFile, match="the array 'mean' is missing"):
        check_arrays("f", {}, LAYOUT.arrays)
    with pytest.raises(DamagedFile, match="'mean'"):
        check_arrays("f", GOOD, LAYOUT.arrays, {"N": 3})


@pytest.mark.parametrize("plain", [{}, {"rate": 10}, {"rate": None}, {"rate": 1, "more": 1}, [], None, {"rate": True}])
def test_plain_data_that_do_not_fit(plain):
    with pytest.raises(DamagedFile, match="settings"):
        LAYOUT.check("f", GOOD, plain)


def test_phones_and_numbers_of_json():
    check_plain("f", ["sil", "a"], PHONES)
    for wrong in (["a"], ["sil", "sil"], ["sil", 1], "sil", ["sil", ""]):
        with pytest.raises(DamagedFile):
            check_plain("f", wrong, PHONES)
    assert parse_plain("[NaN, 1e999, -Infinity, 1e3, 7, " + "9" * 30 + "]") == [None, None, None, 1000.0, 7, None]
