"""The viewing tests of a run: their files, and the rows of systems that they compare."""

from collections.abc import Mapping
from pathlib import Path

from visualspeech.errors import SettingError
from visualspeech.evaluation.published_results import published_names
from visualspeech.fields import FieldError
from visualspeech.models.rows import ModelRow
from visualspeech.planning.systems import by_name, check_override, extended, listed, names_in
from visualspeech.planning.tables import rows_of_entries
from visualspeech.schema import unknown
from visualspeech.study.settings import RECORDED, StudySettings, check_conditions

#: Keys of a study that are no settings of :class:`StudySettings`.
OWN = ("name", "published", "system", "conditions")


def read_studies(given, override: Mapping, folder: Path) -> dict[str, dict]:
    """The studies that a run selects, by name, before their schema is checked.

    Raises
    ------
    SettingError
        As :func:`visualspeech.planning.systems.extended`; two have one name; or a change names none.
    """
    named = listed(given, "studies")
    entries = [(where, extended(one, "studies", folder / "studies", override, where)) for where, one in named]
    studies = by_name(entries, "studies")
    check_override(override, "studies", {*studies, *names_in(folder / "studies")})
    return studies


def complete_study(study: Mapping, systems: Mapping[str, Mapping], codings: Mapping[str, Mapping]) -> dict:
    """A study whose conditions are rows of systems.

    A run may change systems and leave the studies that compare them as they are. What a study lacks is therefore no
    error of the run, but kept for the target that makes studies.

    Parameters
    ----------
    study : with its defaults
    systems, codings : resolved

    Returns
    -------
    ``name``, ``published``, ``settings`` (of :class:`StudySettings`) and ``conditions``: for each its ``name``,
    ``title``, ``system``, ``model`` and ``coding``; the last two are empty for the recorded face. ``problem``: why it
    cannot be made, a sentence; empty where it can. ``skipped``: whether a system that it compares is not selected.

    Raises
    ------
    SettingError
        A setting is wrong, or what is compared does not go together.
    """
    where = f"studies.{study['name']}"
    if study["published"] and study["published"] not in published_names():
        raise SettingError(unknown(f"{where}.published", study["published"], published_names()))
    try:
        settings = StudySettings(**{key: value for key, value in study.items() if key not in OWN})
    except FieldError as error:
        raise error.at(StudySettings.section, where) from None
    entries = [{"system": "", "model": one} if isinstance(one, str) else one for one in study["conditions"]]
    entries = [{"model": "", "title": "", **one, "system": one.get("system") or study["system"]} for one in entries]
    named = list(dict.fromkeys([study["system"], *(one["system"] for one in entries if one["model"] != RECORDED)]))
    done = {
        "name": study["name"],
        "published": study["published"],
        "system": study["system"],
        "settings": {key: value for key, value in study.items() if key not in OWN},
        "conditions": [],
        "skipped": False,
        "problem": "",
    }
    if missing := [name for name in named if name not in systems]:
        problem = f"the study {study['name']} is skipped: it compares models of {missing[0]}, which is not selected."
        return {**done, "skipped": True, "problem": problem}
    try:
        conditions = [_condition(one, systems, f"{where}.conditions.{number}") for number, one in enumerate(entries)]
    except SettingError as error:
        return {**done, "problem": f"{error} Or leave the study out of `studies`."}
    check_conditions(settings.kind, [(one["system"], one["model"]) for one in conditions], where)
    kinds = {codings[systems[name]["coding"]]["kind"] for name in named}
    if len(kinds) > 1:
        raise SettingError(
            f"`{where}.conditions`: {', '.join(named)} show talking heads and drawn points, which viewers could not "
            "compare; name models of systems of one kind."
        )
    return {**done, "conditions": _with_names(conditions)}


def _condition(entry: Mapping, systems: Mapping[str, Mapping], where: str) -> dict:
    system = entry["system"]
    if entry["model"] == RECORDED:
        return {"title": entry["title"] or "recorded", "system": system, "model": "", "coding": ""}
    rows = [ModelRow.of(row) for row in systems[system]["rows"]]
    found = rows_of_entries([entry["model"]], rows)
    if len(found) != 1:
        known = [row.name for row in rows]
        if not found:
            raise SettingError(unknown(where, entry["model"], [RECORDED, *known], f"model of {system}"))
        raise SettingError(f"`{where}: {entry['model']}` is {len(found)} models; name one: {', '.join(found)}.")
    title = next(row.title for row in rows if row.name == found[0])
    return {
        "title": entry["title"] or title,
        "system": system,
        "model": found[0],
        "coding": systems[system]["coding"],
    }


def _with_names(conditions: list[dict]) -> list[dict]:
    """Conditions named by their model, or by system and model where two systems have one of that name."""
    models = [one["model"] or RECORDED for one in conditions]
    return [
        {**one, "name": model if models.count(model) == 1 else f"{one['system']}-{model}"}
        for one, model in zip(conditions, models, strict=True)
    ]
