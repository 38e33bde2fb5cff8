"""Marker sets: the markers or channels of a face that a visual coding models, and the region that each belongs to.

A marker set is data: one YAML file in ``regions`` per set, or the ``regions`` of a corpus, with the names of the
markers of each region. A marker belongs to one region. The order of a set is that of its regions and lists.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from visualspeech.errors import DataError, SettingError
from visualspeech.storage.files import read_text

#: Regions of the face (Sadoughi and Busso 2017, section 3.1), in the order of vectors and tables.
REGIONS = ("upper", "middle", "lower")
#: Names of the landmarks of tracked faces, in the order in which recordings hold them.
LANDMARK_NAMES = tuple(f"point_{number}" for number in range(68))
#: Markers of a set at most, and letters of a name.
MAX_MARKERS, MAX_NAME = 2000, 100


@dataclass(frozen=True)
class MarkerSet:
    """P markers of a face in regions.

    Parameters
    ----------
    names : (P,) names of the markers, in the order of the points
    regions : name -> indices of its markers; each marker is in one region

    Raises
    ------
    DataError
        A name occurs twice, a region is unknown or empty, or a marker is not in exactly one region.
    """

    names: tuple[str, ...]
    regions: Mapping[str, tuple[int, ...]]

    def __post_init__(self) -> None:
        complaint = _complaint(self.names, self.regions)
        if complaint:
            raise DataError(f"marker set: {complaint}")

    @property
    def size(self) -> int:
        """P, the number of markers."""
        return len(self.names)

    def columns(self, dimensions: int) -> dict[str, tuple[int, ...]]:
        """Region -> its columns in vectors (T, P d) that hold the ``dimensions`` coordinates of each marker in turn."""
        return {
            region: tuple(marker * dimensions + one for marker in markers for one in range(dimensions))
            for region, markers in self.regions.items()
        }

    def indices(self, names: Sequence[str]) -> list[int]:
        """Where each of these markers stands in the set.

        Raises
        ------
        DataError
            The set lacks one.
        """
        return _positions(names, self.names, "the marker set")

    def positions_in(self, names: Sequence[str], where: str) -> list[int]:
        """Where each marker of the set stands among the names that a recording gives; ``where`` names it in messages.

        Raises
        ------
        DataError
            The recording lacks one.
        """
        return _positions(self.names, names, where)

    def by_region(self) -> dict[str, list[str]]:
        """Names of the markers by region, as a file holds them."""
        return {region: [self.names[marker] for marker in markers] for region, markers in self.regions.items()}


def marker_set(regions: Mapping[str, Sequence[str]], where: str) -> MarkerSet:
    """A marker set from names by region, as settings and files give them.

    Parameters
    ----------
    regions : region -> names of its markers; a region may be missing
    where : place of the mapping, for messages

    Raises
    ------
    SettingError
        A region is unknown, empty or no list of names, or a marker occurs twice.
    """
    if not isinstance(regions, Mapping) or not regions:
        raise SettingError(f"{where} must name the markers of each region: {', '.join(REGIONS)}.")
    for region, names in regions.items():
        if region not in REGIONS:
            raise SettingError(f"{where} has the unknown region {str(region)[:40]!r}; known are {', '.join(REGIONS)}.")
        if not isinstance(names, list | tuple) or not names or not all(isinstance(one, str) and one for one in names):
            raise SettingError(f"{where}: the region {region} must be a list of names of markers.")
    ordered = {region: list(regions[region]) for region in REGIONS if region in regions}
    names = [name for region in ordered.values() for name in region]
    twice = sorted({name for name in names if names.count(name) > 1}) if len(names) <= MAX_MARKERS else []
    if twice:
        raise SettingError(f"{where} names {', '.join(twice[:6])} more than once; a marker belongs to one region.")
    starts, found = 0, {}
    for region, own in ordered.items():
        found[region] = tuple(range(starts, starts + len(own)))
        starts += len(own)
    try:
        return MarkerSet(tuple(names), found)
    except DataError as error:
        raise SettingError(f"{where}: {error}") from error


def marker_set_names() -> list[str]:
    """Names of the marker sets that come with the library."""
    return sorted(file.stem for file in _FOLDER.glob("*.yaml"))


def landmark_set_names() -> list[str]:
    """Names of the marker sets whose markers are landmarks of tracked faces."""
    return [name for name in marker_set_names() if set(read_marker_set(name).names) <= set(LANDMARK_NAMES)]


def marker_set_path(name: str) -> Path:
    """The file of a marker set.

    Raises
    ------
    SettingError
        There is no marker set of that name.
    """
    if name not in marker_set_names():
        raise SettingError(f"there is no marker set {name[:40]!r}; give one of {', '.join(marker_set_names())}.")
    return _FOLDER / f"{name}.yaml"


def read_marker_set(name: str) -> MarkerSet:
    """The marker set of that name; raises as :func:`marker_set_path` and :func:`marker_set`."""
    return _read(marker_set_path(name))


@lru_cache
def _read(path: Path) -> MarkerSet:
    import yaml

    return marker_set(yaml.safe_load(read_text(path)), f"marker set {path.stem}")


_FOLDER = Path(__file__).parent / "regions"


def _positions(wanted: Sequence[str], given: Sequence[str], where: str) -> list[int]:
    at = {name: number for number, name in enumerate(given)}
    missing = [name for name in wanted if name not in at]
    if missing:
        more = f" and {len(missing) - 6} more" if len(missing) > 6 else ""
        raise DataError(f"{where} lacks the markers {', '.join(missing[:6])}{more}")
    return [at[name] for name in wanted]


def _complaint(names: Sequence[str], regions: Mapping[str, Sequence[int]]) -> str:
    if not names or len(names) > MAX_MARKERS:
        return f"it has {len(names)} markers; 1 to {MAX_MARKERS} are possible"
    if len(set(names)) < len(names):
        return "a marker occurs twice"
    if any(not 0 < len(name) <= MAX_NAME for name in names):
        return f"a marker has a name of more than {MAX_NAME} characters, or none"
    unknown = [str(name) for name in regions if name not in REGIONS]
    if unknown:
        return f"the region {unknown[0][:40]!r} is unknown; known are {', '.join(REGIONS)}"
    if not all(map(len, regions.values())):
        return "a region has no markers"
    if sorted(marker for one in regions.values() for marker in one) != list(range(len(names))):
        return "each marker must be in one region"
    return ""
