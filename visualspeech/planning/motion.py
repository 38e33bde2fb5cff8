"""What a corpus of motion capture says of its files: the markers of each region, format and rates."""

import os
from collections.abc import Mapping
from pathlib import Path

from visualspeech.errors import SettingError
from visualspeech.face.markers import MarkerSet, marker_set, marker_set_names, read_marker_set
from visualspeech.settings import read_yaml

#: Adapter -> the marker set of a corpus that names none.
USUAL = {"iemocap": "iemocap_46", "mocap": "live_link"}


def corpus_markers(corpus: Mapping) -> MarkerSet:
    """The markers that are read of a corpus, by region: those of its ``regions``, or the usual ones of its adapter.

    ``regions`` is the name of a marker set of the library, the path of a YAML file (from the root of the corpus, or
    from the working folder), or names by region.

    Raises
    ------
    SettingError
        There is no such set or file, or it is no marker set; for example a region is unknown.
    """
    given = corpus.get("regions") or USUAL.get(corpus["adapter"], "")
    where = f"`corpora.{corpus['name']}.regions`"
    if isinstance(given, Mapping):
        return marker_set(given, where)
    if given in marker_set_names():
        return read_marker_set(given)
    places = (Path(os.path.expanduser(corpus.get("root") or ""), given), Path(os.path.expanduser(given)))
    path = next((one for one in places if given.endswith((".yaml", ".yml")) and os.path.isfile(one)), None)
    if path is None:
        raise SettingError(
            f"{where}: there is no marker set or file {given[:80]!r}. Give one of {', '.join(marker_set_names())}, the "
            "path of a YAML file with the names of the markers by region (relative to `root`), or the names themselves."
        )
    return marker_set(read_yaml(path), f"{where}, the file {path},")


def motion_source(corpus: Mapping, markers: MarkerSet) -> dict:
    """Plain data of :class:`visualspeech.corpora.motion.MotionSource`."""
    return {
        "names": list(markers.names),
        "format": "iemocap" if corpus["adapter"] == "iemocap" else "csv",
        "rate": corpus.get("rate", 0),
        "timecode_rate": corpus.get("timecode_rate", 0),
    }
