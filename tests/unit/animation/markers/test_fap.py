"""FAP files against a strict reader that knows nothing of the writer."""

import numpy as np
import pytest

from tests.fap_reader import LIMITS, UNSIGNED, FapError, read_fap
from visualspeech.animation.markers.fap import faps, write_fap
from visualspeech.errors import DataError


def test_the_table_is_that_of_the_standard():
    table = {one.number: one for one in faps().values()}
    assert sorted(table) == list(range(3, 69)) == sorted(LIMITS)
    assert {number for number, one in table.items() if not one.negative} == UNSIGNED
    assert {number: one.limit for number, one in table.items()} == LIMITS
    # A turn of the head reaches 180 degrees, an eye 88: the standard's own anchors for the angles.
    assert np.degrees(table[48].limit * 1e-5) == pytest.approx(181, abs=1)
    assert np.degrees(table[23].limit * 1e-5) == pytest.approx(88, abs=1)
    assert all(0 <= one.range <= one.limit for one in table.values())


def test_what_is_written_is_read_again(tmp_path):
    random = np.random.default_rng(1)
    names = ["raise_b_midlip", "open_jaw", "raise_r_o_eyebrow", "pull_r_ear"]
    values = {name: random.uniform(-150, 150, 7) for name in names}
    write_fap(tmp_path / "a b.fap", values, 25)
    found = read_fap((tmp_path / "a b.fap").read_text())
    assert (found.name, found.rate, len(found.frames)) == ("a_b", 25, 7)
    for index, frame in enumerate(found.frames):
        assert frame == {
            faps()[name].number: (max(0, round(values[name][index])) if name == "open_jaw"
                                  else round(values[name][index]),)
            for name in names
        }  # fmt: skip


def test_values_beyond_the_standard_are_limited(tmp_path):
    everything = {name: np.array([-1e7, 1e7]) for name in faps()}
    write_fap(tmp_path / "a.fap", everything, 120, "x")
    low, high = read_fap((tmp_path / "a.fap").read_text()).frames
    assert high == {number: (limit,) for number, limit in LIMITS.items()}
    assert low == {number: (0 if number in UNSIGNED else -limit,) for number, limit in LIMITS.items()}


@pytest.mark.parametrize(
    ("values", "rate", "said"),
    [
        ({"open_mouth": [1.0]}, 25, "open_mouth"),
        ({}, 25, "one is needed"),
        ({"open_jaw": [1.0], "shift_jaw": [1.0, 2.0]}, 25, "lengths"),
        ({"open_jaw": [float("nan")]}, 25, "open_jaw"),
        ({"open_jaw": [1.0]}, 29.97, "whole"),
    ],
)
def test_what_no_file_can_hold_is_refused(values, rate, said, tmp_path):
    with pytest.raises(DataError, match=said):
        write_fap(tmp_path / "a.fap", {name: np.array(one) for name, one in values.items()}, rate)
    assert not list(tmp_path.iterdir())


MASK = " ".join(["0", "0", "1", *["0"] * 65])
VISEME = " ".join(["1", "1", "1", *["0"] * 65])
GOOD = f"2.1 name 25 2\n{MASK}\n0 10\n{MASK}\n1 20\n"


def test_the_reader_accepts_visemes_and_expressions_of_other_writers():
    found = read_fap(f"2.1 n 25 1\n{VISEME}\n0 1 2 3 4 1 2 3 4 5 6 77\n")
    assert found.frames == [{1: (1, 2, 3, 4), 2: (1, 2, 3, 4, 5, 6), 3: (77,)}]
    assert read_fap(GOOD).frames == [{3: (10,)}, {3: (20,)}]


@pytest.mark.parametrize(
    "text",
    [
        "",
        GOOD[:-1],
        GOOD.replace("2.1", "2.0"),
        GOOD.replace("name ", ""),
        GOOD.replace("25 2", "25 3"),
        GOOD.replace("25 2", "0 2"),
        GOOD.replace("0 10", "1 10"),
        GOOD.replace("0 10", "0 10 11"),
        GOOD.replace("0 10", "0"),
        GOOD.replace("0 10", "0 10.5"),
        GOOD.replace("0 10", "0 -10"),
        GOOD.replace("0 10", "0 4321"),
        GOOD.replace("0 10", "0  10"),
        GOOD.replace(MASK, MASK[:-2], 1),
        GOOD.replace(MASK, MASK.replace("1", "2"), 1),
        GOOD + "\n",
        GOOD.replace("\n", "\r\n"),
        GOOD.replace(MASK, VISEME, 1),
    ],
)
def test_the_reader_refuses_broken_files(text):
    with pytest.raises(FapError):
        read_fap(text)
