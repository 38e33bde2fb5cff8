"""The systems of a run: their files with what they extend, their codings, and which corpora they can run on."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from visualspeech.errors import SettingError
from visualspeech.evaluation.published_results import published_names
from visualspeech.features.blocks.base import block_class, block_kinds, is_segmental, needs_arpabet, needs_of
from visualspeech.fields import section_schema, with_defaults
from visualspeech.models.entries import model_mistakes
from visualspeech.models.registry import expand
from visualspeech.models.rows import ORACLE, ModelRow
from visualspeech.planning.blocks import (
    package_mistakes,
    part_mistakes,
    read_faces,
    segment_mistakes,
    viseme_number_mistakes,
)
from visualspeech.planning.own_metrics import metric_mistakes, own_metrics
from visualspeech.planning.tables import resolved_tables, rows_of_entries, table_mistakes
from visualspeech.schema import check, mistakes, unknown
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
    "arpabet": "phones of ARPAbet (the corpus has `alignment.phones: as_is`; map them onto ARPAbet by a table)",
}
#: Kinds of input blocks that a program gives (:func:`visualspeech.train`) and no system can have.
GIVEN = ("arrays",)
#: A name, which becomes a folder of the results.
NAME = {
    "type": "string",
    "pattern": r"^[A-Za-z0-9][A-Za-z0-9_-]{0,63}\Z",
    "description": "Folder of the results: at most 64 letters, digits, - and _.",
}


def read_named(given, where: str, folder: Path) -> dict:
    """One of a list of named things: a name in a folder of the configuration, the path of a YAML file, or a mapping.

    Parameters
    ----------
    given : name, path ending in ``.yaml``, or mapping
    where : its place in the settings, for messages
    folder : of the files that are known by name

    Returns
    -------
    The mapping, with ``name``.

    Raises
    ------
    SettingError
        The name is unknown, a file cannot be read, or a mapping has no name.
    """
    if isinstance(given, Mapping):
        check(given, {"type": "object", "required": ["name"], "properties": {"name": NAME}}, where)
        return dict(given)
    known = sorted(names_in(folder))
    if given in known:
        path = folder / f"{given}.yaml"
    elif isinstance(given, str) and given.endswith((".yaml", ".yml")):
        path = Path(given)
    else:
        raise SettingError(f"{unknown(where, given, known)} Or give the path of a YAML file.{_as_list(given, known)}")
    found = {"name": path.stem, **read_yaml(path)}
    check(found, {"type": "object", "properties": {"name": NAME}}, str(path))
    return found


def _as_list(given, known: Sequence[str]) -> str:
    """How to write a list, where several known names were given as one text; empty elsewhere."""
    names = [one.strip(" []'\"") for one in str(given).split(",")] if isinstance(given, str) else []
    if len(names) < 2 and not str(given).startswith("["):
        return ""
    return f" A list is written [{', '.join(names)}]." if all(name in known for name in names) else ""


def extended(given, kind: str, folder: Path, override: Mapping, where: str = "", seen: Sequence[str] = ()) -> dict:
    """A named mapping laid over the one that it ``extends``, the run's own changes over both.

    The changes of a name that is extended count for what extends it too: an overlay that changes ``fan2015`` changes
    ``fan2015_50hz`` alike.

    Parameters
    ----------
    given : name, path or mapping
    kind : systems or codings
    folder : of the files that are known by name
    override : the run's own changes, by name
    where : place of ``given`` in the settings, for messages; empty: ``kind``
    seen : names that led here by ``extends``

    Raises
    ------
    SettingError
        As :func:`read_named`, or the chain of ``extends`` leads back to itself.
    """
    where = where or kind
    own = read_named(given, where, folder)
    name, above = own["name"], own.pop("extends", None)
    if name in seen:
        raise SettingError(f"`{where}: {given}` leads back to {name} ({' -> '.join([*seen, name])}); extend another.")
    if above is not None:
        below = extended(above, kind, folder, override, f"{kind}.{name}.extends", (*seen, name))
        own = {**merged(below, own), "name": name}
    return {**merged(own, override.get(name, {})), "name": name}


def read_systems(given, codings_override: Mapping, systems_override: Mapping, folder: Path):
    """The systems and codings that a run selects, before their schema is checked: two mappings by name.

    Raises
    ------
    SettingError
        As :func:`extended`; two systems or two different codings have one name; or a change names a system or coding
        that is not there.
    """
    entries = []
    for where, one in listed(given, "systems"):
        system = extended(one, "systems", folder / "systems", systems_override, where)
        entries.append((where, system))
    systems, codings = by_name(entries, "systems"), {}
    for name, system in systems.items():
        if "coding" not in system:
            continue  # its schema says so
        where = f"systems.{name}.coding"
        coding = extended(system["coding"], "codings", folder / "codings", codings_override, where)
        if codings.setdefault(coding["name"], coding) != coding:
            raise SettingError(
                f"`{where}`: another system defines a coding named {coding['name']} with different settings; give one "
                "of them another name."
            )
        systems[name] = {**system, "coding": coding["name"]}
    check_override(systems_override, "systems", {*systems, *names_in(folder / "systems")})
    check_override(codings_override, "codings", {*codings, *names_in(folder / "codings")})
    return systems, codings


def listed(given, key: str) -> list[tuple[str, object]]:
    """Entries of a key that may be a list or a single one, each with its place in the settings."""
    if isinstance(given, list | tuple):
        return [(f"{key}.{number}", one) for number, one in enumerate(given)]
    return [(key, given)]


def by_name(entries: Sequence[tuple[str, dict]], key: str) -> dict[str, dict]:
    """Mappings by their name, from (place in the settings, mapping).

    Raises
    ------
    SettingError
        Two have one name.
    """
    found: dict[str, dict] = {}
    for where, entry in entries:
        name = entry["name"]
        if name.lower() in map(str.lower, found):
            raise SettingError(f"`{where}: {name}`: `{key}` names {name} more than once (capitals do not count); give "
                               "each its own name.")  # fmt: skip
        found[name] = entry
    return found


def names_in(folder: Path) -> set[str]:
    return {path.stem for path in folder.glob("*.yaml")}


def check_override(override: Mapping, key: str, known: set[str]) -> None:
    """Check changes of systems, codings or studies: each names one, and leaves its name and what it extends."""
    one = "study" if key == "studies" else key[:-1]
    found = [unknown(f"override.{key}", name, sorted(known)) for name in override if name not in known]
    for name, changes in override.items():
        found += [
            f"`override.{key}.{name}.{fixed}` cannot be changed for one run; write it in the file of a {one} of "
            "its own."
            for fixed in ("name", "extends")
            if fixed in changes
        ]
    if found:
        raise SettingError("\n".join(found))


def input_mistakes(system: Mapping, where: str) -> list[str]:
    """What is wrong with a system's measures, blocks and models, a sentence for each mistake; the rest is its schema's.

    Parameters
    ----------
    system : with or without its defaults
    where : its place in the settings, for messages
    """
    measures = metric_mistakes(system.get("tables"), f"{where}.tables")
    blocks = system.get("blocks")
    if not isinstance(blocks, Mapping):
        return measures
    given = {str(name): block for name, block in blocks.items() if isinstance(block, Mapping)}
    found = [said for name, block in given.items() for said in _block_mistakes(block, f"{where}.blocks.{name}")]
    found = measures + found
    models = system.get("models")
    return found + (model_mistakes(models, given, f"{where}.models") if isinstance(models, Mapping) else [])


def block_schema(kind: str) -> dict:
    """JSON Schema of an input block of a kind."""
    cls = block_class(kind).settings
    naming = _kind_schema()
    own = section_schema(cls)["properties"] if cls else {}
    return {"type": "object", "additionalProperties": False, "properties": {"kind": naming, **own}}


def _kind_schema() -> dict:
    return {"enum": [kind for kind in block_kinds() if kind not in GIVEN], "description": "Kind of input block."}


def _block_mistakes(block: Mapping, where: str) -> list[str]:
    naming = {"kind": _kind_schema()}
    found = mistakes(block, {"type": "object", "required": ["kind"], "properties": naming}, where)
    return found or mistakes(block, block_schema(block["kind"]), where)


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
        A block, an entry of ``models`` or a model that is named elsewhere is mistaken; a line for each mistake.
    """
    where = f"systems.{system['name']}"
    found = input_mistakes(system, where)
    if found:
        raise SettingError("\n".join(found))
    blocks = {name: _block(block, f"{where}.blocks.{name}") for name, block in system["blocks"].items() if block}
    seeds = system["seeds"] or [seed]
    rows = expand(system["models"], blocks, system["training"], seeds, f"{where}.models")
    found = part_mistakes(blocks, where) + package_mistakes(blocks, where)
    found += viseme_number_mistakes(system["viseme_numbers"]["block"], blocks, where)
    if found:
        raise SettingError("\n".join(found))
    rows = [replace(row, role=ORACLE) if row.role == "model" and read_faces(row.reads, blocks) else row for row in rows]
    found = segment_mistakes(rows, blocks, where)
    found += _naming_mistakes(system, rows, where) + _sound_mistakes(system, blocks, rows, where)
    found += _window_mistakes(system, blocks, rows, where)
    if found:
        raise SettingError("\n".join(found))
    models = [row for row in rows if row.role == "model"]
    shown = system["videos"]["model"] or (models[0].name if models else "training_mean")
    return {
        **{key: value for key, value in system.items() if key not in ("models", "training", "seeds")},
        "seeds": seeds,
        # What its models read counts among its needs, whether or not its file says so.
        "needs": list(dict.fromkeys([*system["needs"], *sorted(set().union(*(_asks(row, blocks) for row in rows)))])),
        "blocks": blocks,
        "rows": [row.plain() for row in rows],
        "videos": {**system["videos"], "model": shown},
        "sound_model": next(iter(rows_of_entries(filter(None, [system["sound_model"]]), rows)), ""),
        "tables": resolved_tables(system["tables"], rows),
        "own_metrics": own_metrics(system["tables"]),
        "preference": {**system["preference"], "models": _pair(system, shown, rows)},
    }


def _block(block: Mapping, where: str) -> dict:
    """Kind and settings of an input block, defaults filled in."""
    given = {name: value for name, value in block.items() if name != "kind"}
    cls = block_class(block["kind"]).settings
    return {"kind": block["kind"], "settings": with_defaults(cls, given, where=where) if cls else {}}


def _sound_mistakes(system: Mapping, blocks: Mapping, rows: Sequence[ModelRow], where: str) -> list[str]:
    """Rows that are to speak for recordings and do not read sound alone."""
    wanted = system["sound_model"]
    return [
        f"`{where}.sound_model: {wanted}` must read input blocks of sound alone; {row.name} reads "
        f"{', '.join(row.reads) or 'none'}."
        for row in rows
        if wanted and wanted in (row.group, row.name) and _needs_of_row(row, blocks) != {"audio"}
    ]


def _window_mistakes(system: Mapping, blocks: Mapping, rows: Sequence[ModelRow], where: str) -> list[str]:
    """Windows that are no frames: shorter than a frame, or of a block of segments; a sentence for each entry's."""
    found = {}
    for group, name, seconds in ((row.group, name, each) for row in rows for name, each in row.windows.items()):
        key = f"`{where}.models.{group}.reads`: the window of {name}"
        if is_segmental(block_class(blocks[name]["kind"])):
            found[key] = f"{key} must be left out: the block has a row per segment, not per frame."
        elif round(seconds * system["rate"]) < 1:
            least = 1 / system["rate"]
            found[key] = f"{key}, {seconds:g} s, is less than a frame of {least:g} s; lengthen it or leave it out."
    return list(found.values())


def _needs_of_row(row: ModelRow, blocks: Mapping) -> set[str]:
    """What the input blocks of a row are computed from."""
    return {need for name in row.reads for need in needs_of(block_class(blocks[name]["kind"]))}


def _asks(row: ModelRow, blocks: Mapping) -> set[str]:
    """What the input blocks of a row are computed from, and whether they know no other phones than ARPAbet."""
    own = {"arpabet" for name in row.reads if needs_arpabet(block_class(blocks[name]["kind"]))}
    return _needs_of_row(row, blocks) | own


def _naming_mistakes(system: Mapping, rows: Sequence[ModelRow], where: str) -> list[str]:
    """What is wrong with the names of models in videos, preference and tables."""
    trained = [row.name for row in rows if row.role != "floor"]
    known = list(dict.fromkeys([*system["models"], *(row.name for row in rows)]))
    pair = system["preference"]["models"]
    found = []
    if system["published"] and system["published"] not in published_names():
        found.append(unknown(f"{where}.published", system["published"], published_names()))
    found += table_mistakes(system["tables"], known, f"{where}.tables")
    if system["sound_model"] and system["sound_model"] not in known:
        found.append(unknown(f"{where}.sound_model", system["sound_model"], known, "entry of `models` and no row"))
    shown = system["videos"]["model"]
    if shown and shown not in trained:
        found.append(unknown(f"{where}.videos.model", shown, trained, "model of the system"))
    found += [
        unknown(f"{where}.preference.models.{number}", name, trained, "model of the system")
        for number, name in enumerate(pair)
        if name not in trained
    ]
    found += [
        unknown(f"{where}.trajectories.models.{number}", name, trained, "model of the system")
        for number, name in enumerate(system["trajectories"]["models"])
        if name not in trained
    ]
    if len(pair) == 1:
        found.append(f"`{where}.preference.models: [{pair[0]}]` must name two models, or none to have them chosen.")
    return found


def _pair(system: Mapping, shown: str, rows: Sequence[ModelRow]) -> list[str]:
    """The two models of a preference test: as given, or the shown one and the last reference or baseline."""
    names = system["preference"]["models"]
    if names:
        return list(names)
    family = next(row.family for row in rows if row.name == shown)
    others = [row.name for row in rows if row.role == "model" and row.family != family]
    references = rows_of_entries(system["tables"]["gains"]["references"], rows)
    others = [name for name in references if name in others] or others
    others = others or [row.name for row in rows if row.role == "baseline"]
    return [shown, next((name for name in reversed(others) if name != shown), "training_mean")]


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
