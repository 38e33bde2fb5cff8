"""Marker sets: the files of the library, regions that settings give, columns."""

import pytest

from visualspeech.errors import DataError, SettingError
from visualspeech.face.markers import (
    LANDMARK_NAMES,
    MarkerSet,
    landmark_set_names,
    marker_set,
    marker_set_names,
    marker_set_path,
    read_marker_set,
)


def test_the_sets_have_the_markers_of_their_sources():
    sizes = {name: {region: len(one) for region, one in read_marker_set(name).regions.items()}
             for name in marker_set_names()}  # fmt: skip
    assert sizes == {
        "iemocap_46": {"upper": 19, "middle": 12, "lower": 15},  # Sadoughi and Busso 2017, section 3.2
        "landmarks_68": {"upper": 22, "middle": 17, "lower": 29},
        "live_link": {"upper": 19, "middle": 5, "lower": 28},
    }
    assert set(read_marker_set("landmarks_68").names) == set(LANDMARK_NAMES)
    assert landmark_set_names() == ["landmarks_68"]


def test_columns_hold_every_coordinate_once_in_its_region():
    markers = marker_set({"lower": ["chin", "lip"], "upper": ["brow"]}, "here")
    assert markers.names == ("brow", "chin", "lip")  # in the order of the regions
    assert markers.columns(2) == {"upper": (0, 1), "lower": (2, 3, 4, 5)}
    assert markers.by_region() == {"upper": ["brow"], "lower": ["chin", "lip"]}
    assert marker_set(markers.by_region(), "here") == markers


def test_a_set_finds_its_markers_in_a_recording():
    markers = marker_set({"upper": ["brow"], "lower": ["chin"]}, "here")
    assert markers.positions_in(["chin", "hand", "brow"], "s1.csv") == [2, 0]
    assert markers.indices(["chin"]) == [1]
    with pytest.raises(DataError, match=r"s1\.csv lacks the markers chin"):
        markers.positions_in(["brow"], "s1.csv")
    with pytest.raises(DataError, match="lacks the markers nose"):
        markers.indices(["nose"])


@pytest.mark.parametrize(
    ("regions", "said"),
    [
        ({}, "must name the markers"),
        ([], "must name the markers"),
        ({"left": ["a"]}, "unknown region 'left'; known are upper, middle, lower"),
        ({"upper": []}, "region upper must be a list"),
        ({"upper": "a"}, "region upper must be a list"),
        ({"upper": [1]}, "region upper must be a list"),
        ({"upper": ["a"], "lower": ["b", "a"]}, "names a more than once"),
        ({"upper": ["a" * 101]}, "more than 100 characters"),
        ({"upper": [str(one) for one in range(2001)]}, "has 2001 markers"),
    ],
)
def test_mistaken_regions_are_one_sentence(regions, said):
    with pytest.raises(SettingError, match=said) as error:
        marker_set(regions, "`corpora.mine.regions`")
    assert str(error.value).startswith("`corpora.mine.regions`")


def test_unknown_sets_and_incomplete_ones():
    with pytest.raises(SettingError, match="no marker set 'iemocap'; give one of iemocap_46, landmarks_68, live_link"):
        marker_set_path("iemocap")
    with pytest.raises(DataError, match="each marker must be in one region"):
        MarkerSet(("a", "b"), {"upper": (0,)})
    with pytest.raises(DataError, match="each marker must be in one region"):
        MarkerSet(("a", "b"), {"upper": (0, 1), "lower": (1,)})
