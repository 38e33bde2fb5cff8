"""The systems of a run: their files with what they extend, their codings, and which corpora they can run on."""

import os
from collections.abc import Collection, Mapping, Sequence
from dataclasses import fields
from pathlib import Path

from visualspeech.errors import SettingError
from visualspeech.evaluation.published_results import published
from visualspeech.face.aam.model import AamSettings
from visualspeech.face.point_sets import read_point_set
from visualspeech.features.blocks.base import block_class, block_kinds
from visualspeech.fields import with_defaults
from visualspeech.models.registry import expand
from visualspeech.models.rows import ModelRow
from visualspeech.schema import did_you_mean
from visualspeech.settings import merged, read_yaml

#: What a system may need of a corpus, and how a message says that it is missing.
NEEDS = {
    "video": "video of every utterance",
    "audio": "sound of every utterance",
    "text": "transcripts",
    "motion": "motion capture of every utterance",
    "faces": "video or motion capture of every utterance",
    "one_speaker": "recordings of one speaker (select one with `speaker` of the corpus)",
    "emotion": "an emotion label of the utterances",
}


def read_named(given, key: str, folder: Path) -> dict:
    """One of a list of named things: a name in a folder of the configuration, the path of a YAML file, or a mapping.

    Parameters
    ----------
    given : name, path ending in ``.yaml``, or mapping
    key : of the settings, for messages
    folder : of the files that are known by name

    Returns
    -------
    The mapping, with ``name``.

    Raises
    ------
    SettingError
        The name is unknown, or a mapping has no name.
    """
    if isinstance(given, Mapping):
        if not isinstance(given.get("name"), str):
            raise SettingError(f"`{key}`: an entry that is a mapping needs a `name`.")
        return dict(given)
    known = sorted(path.stem for path in folder.glob("*.yaml"))
    if isinstance(given, str) and given in known:
        path = folder / f"{given}.yaml"
    elif isinstance(given, str) and given.endswith((".yaml", ".yml")):
        path = Path(given)
    else:
        raise SettingError(
            f"`{key}: {given}` is not known. Known: {', '.join(known)}." + did_you_mean(str(given), known)
        )
    return {"name": path.stem, **read_yaml(path)}


def extended(given, key: str, folder: Path, override: Mapping, seen: Sequence[str] = ()) -> dict:
    """A named mapping laid over the one that it ``extends``, the run's own changes over both.

    The changes of a name that is extended count for what extends it too: an overlay that changes ``fan2015`` changes
    ``fan2015_50hz`` alike.

    Raises
    ------
    SettingError
        As :func:`read_named`, or the chain of ``extends`` leads back to itself.
    """
    own = read_named(given, key, folder)
    name, above = own["name"], own.pop("extends", None)
    if above is not None:
        if not isinstance(above, str) or above in (*seen, name):
            raise SettingError(f"`{key}.{name}.extends: {above}` must name another file that does not lead back to it.")
        below = extended(above, f"{key}.{name}.extends", folder, override, (*seen, name))
        own = {**merged(below, own), "name": name}
    return {**merged(own, override.get(name) or {}), "name": name}


def read_systems(given: Sequence, codings_override: Mapping, systems_override: Mapping, folder: Path):
    """The systems and codings that a run selects, before their schema is checked: two mappings by name.

    Raises
    ------
    SettingError
        As :func:`extended`; two codings of one name differ; or a change names a system or coding that is not there.
    """
    systems, codings = {}, {}
    for entry in given:
        system = extended(entry, "systems", folder / "systems", systems_override)
        if str(system["name"]).lower() in map(str.lower, systems):
            raise SettingError(f"`systems` names {system['name']} more than once (capitals do not count).")
        if not system.get("coding"):
            raise SettingError(
                f"`systems.{system['name']}` lacks `coding`. Known: {', '.join(_names(folder / 'codings'))}."
            )
        coding = extended(system.get("coding"), f"systems.{system['name']}.coding", folder / "codings",
                          codings_override)  # fmt: skip
        if codings.setdefault(coding["name"], coding) != coding:
            raise SettingError(
                f"two systems define a coding named {coding['name']} with different settings; give one another name."
            )
        systems[system["name"]] = {**system, "coding": coding["name"]}
    _check_override(systems_override, "systems", {*systems, *_names(folder / "systems")})
    _check_override(codings_override, "codings", {*codings, *_names(folder / "codings")})
    return systems, codings


def _names(folder: Path) -> list[str]:
    return sorted(path.stem for path in folder.glob("*.yaml"))


def _check_override(override: Mapping, key: str, known: set[str]) -> None:
    for name in override:
        if name not in known:
            raise SettingError(
                f"`override.{key}.{name}` is not known. Known: {', '.join(sorted(known))}."
                + did_you_mean(str(name), sorted(known))
            )


def complete_system(system: Mapping, seed: int) -> dict:
    """A system's settings with blocks, rows and the models of videos and tables resolved.

    Parameters
    ----------
    system : checked against its schema, defaults filled in
    seed : of the run, where the system gives no seeds

    Returns
    -------
    The settings with ``rows`` (plain data of :class:`ModelRow`) in place of ``models``; ``tables`` and ``preference``
    name rows in place of entries.

    Raises
    ------
    SettingError
        A block, an entry of ``models`` or a model that is named elsewhere is mistaken.
    """
    where = f"systems.{system['name']}"
    blocks = {name: _block(block, f"{where}.blocks.{name}") for name, block in system["blocks"].items() if block}
    seeds = system["seeds"] or [seed]
    rows = expand(system["models"], blocks, system["training"], seeds, f"{where}.models")
    models = [row for row in rows if row.role == "model"]
    shown = system["videos"]["model"] or (models[0].name if models else "training_mean")
    _row_named(shown, rows, f"{where}.videos.model")
    tables = system["tables"]
    published(system["published"])
    entries = list(dict.fromkeys([*system["models"], *(row.group for row in rows), *(row.name for row in rows)]))
    for key, names in {"topologies": tables["topologies"], **tables["gains"]}.items():
        for name in names:
            _check_known(name, entries, f"{where}.tables.{key if key in tables else f'gains.{key}'}")
    return {
        **{key: value for key, value in system.items() if key not in ("models", "training", "seeds")},
        "seeds": seeds,
        "blocks": blocks,
        "rows": [row.plain() for row in rows],
        "videos": {**system["videos"], "model": shown},
        "tables": {
            **tables,
            "topologies": _of_groups(tables["topologies"], rows),
            "gains": {key: _of_groups(names, rows) for key, names in tables["gains"].items()},
        },
        "preference": {**system["preference"], "models": _pair(system, shown, rows, where)},
    }


def check_speaker(speak: Mapping, systems: Mapping[str, Mapping]) -> None:
    """Check that ``speak`` names a system of the run and one of its models.

    Raises
    ------
    SettingError
        It does not.
    """
    if speak["system"]:
        _check_known(speak["system"], systems, "speak.system")
    system = systems[speak["system"] or next(iter(systems))]
    if speak["model"]:
        _row_named(speak["model"], [ModelRow.of(row) for row in system["rows"]], "speak.model")


def _block(block: Mapping, where: str) -> dict:
    """Kind and settings of an input block, defaults filled in."""
    kind, kinds = block.get("kind"), block_kinds()
    if kind not in kinds:
        raise SettingError(
            f"`{where}.kind: {kind}` is unknown. Known: {', '.join(kinds)}." + did_you_mean(str(kind), kinds)
        )
    given = {name: value for name, value in block.items() if name != "kind"}
    cls = block_class(kind).settings
    known = [one.name for one in fields(cls)] if cls else []
    for name in given:
        if name not in known:
            raise SettingError(f"unknown setting `{where}.{name}`. Known here: {', '.join(['kind', *known])}.")
    try:
        return {"kind": kind, "settings": with_defaults(cls, given) if cls else {}}
    except SettingError as error:
        raise SettingError(f"`{where}`: {error}") from error


def _check_known(name: str, known: Collection[str], where: str) -> None:
    if name not in known:
        raise SettingError(
            f"`{where}: {name}` is unknown. Known: {', '.join(known)}." + did_you_mean(str(name), list(known))
        )


def _of_groups(names: Sequence[str], rows: Sequence[ModelRow]) -> list[str]:
    """Names of the rows that entries of ``models`` ask for; an entry that the system leaves out asks for none."""
    return [row.name for name in names for row in rows if name in (row.group, row.name)]


def _row_named(name: str, rows: Sequence[ModelRow], where: str) -> ModelRow:
    found = next((row for row in rows if row.name == name), None)
    if found is None or found.role == "floor":
        known = [row.name for row in rows if row.role != "floor"]
        raise SettingError(f"`{where}: {name}` is no model of the system. Known: {', '.join(known)}."
                           + did_you_mean(name, known))  # fmt: skip
    return found


def _pair(system: Mapping, shown: str, rows: Sequence[ModelRow], where: str) -> list[str]:
    """The two models of a preference test: as given, or the shown one and the last reference or baseline."""
    names = system["preference"]["models"]
    if len(names) == 1:
        raise SettingError(f"`{where}.preference.models: [{names[0]}]` must name two models, or none for the default.")
    if not names:
        others = [row.name for row in rows if row.role == "model" and row.family != _family(shown, rows)]
        others = others or [row.name for row in rows if row.role == "baseline"]
        names = [shown, next(name for name in reversed(others) if name != shown)]
    for name in names:
        _row_named(name, rows, f"{where}.preference.models")
    return list(names)


def _family(name: str, rows: Sequence[ModelRow]) -> str:
    return next(row.family for row in rows if row.name == name)


def check_coding(coding: Mapping) -> None:
    """Check that a visual coding can have the components that its settings ask for.

    Raises
    ------
    SettingError
        It cannot, or its point set is unknown.
    """
    try:
        settings = AamSettings(**coding["aam"])
        settings.check_possible(settings.images, read_point_set(coding["points"]).freedom)
    except SettingError as error:
        raise SettingError(f"`codings.{coding['name']}`: {error}") from error


def missing_needs(system: Mapping, gives: frozenset[str]) -> list[str]:
    """What a system needs and a corpus does not give, in words."""
    return [NEEDS[need] for need in system["needs"] if need not in gives]


def absolute_root(corpus: dict, given, folder: Path) -> dict:
    """A corpus whose relative root counts from its own file where that is no file of the configuration's folder."""
    root = corpus.get("root")
    of_file = isinstance(given, str) and given.endswith((".yaml", ".yml"))
    if of_file and isinstance(root, str) and root and not os.path.isabs(os.path.expanduser(root)):
        if Path(given).parent != folder:
            return {**corpus, "root": str(Path(given).parent / root)}
    return corpus
