"""The visual codings of a run: the settings of each kind, and what systems may ask of them."""

from collections.abc import Mapping

from visualspeech.errors import SettingError
from visualspeech.face.aam.model import AamSettings
from visualspeech.face.markers import landmark_set_names
from visualspeech.face.point_sets import point_set_names, read_point_set
from visualspeech.fields import FieldError
from visualspeech.models.families import FAMILIES
from visualspeech.models.lips import WEIGHTS
from visualspeech.planning.tables import coding_mistakes
from visualspeech.schema import fill_defaults, unknown

#: Kind of a visual coding -> the sections that it has beside those of all kinds.
SECTIONS = {"aam": ("texture", "drift", "aam", "source", "fitting"), "markers": ("markers",)}
#: Kind of a visual coding -> what a corpus must give for it.
NEEDED = {"aam": "video", "markers": "faces"}


def coding_schema(schema: Mapping, coding: Mapping) -> dict:
    """What the schema of codings says of one of this kind; all of it where the kind is unknown."""
    kind = coding.get("kind")
    if not isinstance(kind, str) or kind not in SECTIONS:
        return dict(schema)
    others = {key for other, keys in SECTIONS.items() if other != kind for key in keys}
    return {**schema, "properties": {key: one for key, one in schema["properties"].items() if key not in others}}


def complete_coding(coding: Mapping, schema: Mapping, where: str) -> dict:
    """A coding that fits its schema, with all defaults.

    Raises
    ------
    SettingError
        Its point set or marker set is unknown, or an AAM asks for more components than its images and points can have.
    """
    filled = fill_defaults(coding, coding_schema(schema, coding), where)
    pictured = filled["kind"] == "aam"
    known, what = (point_set_names(), "point set") if pictured else (landmark_set_names(), "marker set of landmarks")
    if filled["points"] not in known:
        raise SettingError(unknown(f"{where}.points", filled["points"], known, what))
    if pictured:
        try:
            points = read_point_set(filled["points"])
            AamSettings(**filled["aam"]).check_possible(filled["aam"]["images"], points.freedom)
        except FieldError as error:
            raise error.at("aam", f"{where}.aam") from None
    return filled


def with_needs(system: Mapping, coding: Mapping) -> dict:
    """A resolved system that also needs what its visual coding reads of a corpus."""
    return {**system, "needs": list(dict.fromkeys([*system["needs"], NEEDED[coding["kind"]]]))}


def kind_mistakes(system: Mapping, coding: Mapping) -> list[str]:
    """What a system asks of a visual coding that its kind does not have, a sentence for each mistake.

    Parameters
    ----------
    system, coding : resolved
    """
    where, kind = f"systems.{system['name']}", coding["kind"]
    found = [
        f"`{where}.models.{row['group']}.family: {row['family']}` predicts regions of the face, and the visual coding "
        f"{coding['name']} of the kind {kind} has none. Choose a coding of the kind markers, or another family."
        for row in system["rows"]
        if FAMILIES[row["family"]].regions and kind != "markers"
    ]
    found += coding_mistakes(system["tables"], kind, f"{where}.tables")
    if kind != "markers":
        return list(dict.fromkeys(found))
    found += [
        f"`{where}.models.{row['group']}.training.{key}` weights the opening of the lips, and a visual coding of the "
        "kind markers does not know which markers are lips. Leave it out."
        for row in system["rows"]
        for key in WEIGHTS
        if row["training"].get(key)
    ]
    if system["sound_model"]:
        found.append(f"`{where}.sound_model` must be empty: {no_picture(system['name'], coding)}.")
    return list(dict.fromkeys(found))


def no_picture(system: str, coding: Mapping) -> str:
    """Why a system cannot show a talking head, as the rest of a sentence."""
    return (
        f"{system} predicts markers of the face (visual coding {coding['name']}) and no picture that a talking head "
        "could show"
    )
