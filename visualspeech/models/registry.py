"""The families of models by name, and the rows that a system's ``models:`` asks for. For planning: imports no model.

A family is named by the module that implements it, with ``fit(task) -> Fitted`` and ``load(path) -> Model``
(:mod:`visualspeech.models.task`). The module is imported when a model is trained, and its code is part of the digest of
its own rows alone: a new family re-trains nobody.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from dataclasses import fields as dataclass_fields
from importlib import import_module
from itertools import product
from pathlib import Path

from visualspeech.errors import SettingError, StorageError
from visualspeech.fields import with_defaults
from visualspeech.models.rows import ModelRow
from visualspeech.models.training_settings import training_fields, training_settings
from visualspeech.schema import did_you_mean, settings_class
from visualspeech.storage import read_model_of


@dataclass(frozen=True)
class Family:
    """One family of models.

    Parameters
    ----------
    module : that implements it
    settings : ``module:Class`` of its settings, importable without torch; empty for none
    trained : whether it is trained by the loop of :mod:`visualspeech.models.training`
    reads : whether its models read input blocks
    role : of its rows, see :data:`visualspeech.models.rows.ROLES`
    grid : settings that may be lists in ``models:``; every combination is a row
    cell : name of such a row, from the settings
    title : of a row in tables, from its name and settings
    """

    module: str
    settings: str = ""
    trained: bool = False
    reads: bool = True
    role: str = "model"
    grid: tuple[str, ...] = ()
    cell: Callable[[Mapping], str] = lambda settings: ""
    title: Callable[[str, Mapping], str] = lambda name, settings: name


_HMM_TITLES = {"monophone": "monophone HMM", "tied": "tied-state triphone HMM", "mge": "MGE-trained HMM"}

FAMILIES = {
    "stack": Family(
        "visualspeech.models.stack",
        "visualspeech.models.stack_settings:StackSettings",
        trained=True,
        grid=("letters", "nodes"),
        cell=lambda settings: f"{settings['letters']}-{settings['nodes']}",
    ),
    "hmm": Family(
        "visualspeech.models.hmm.family",
        "visualspeech.models.hmm.model:HmmSettings",
        title=lambda name, settings: _HMM_TITLES[settings["variant"]],
    ),
    "lookup": Family(
        "visualspeech.models.lookup",
        "visualspeech.models.lookup_settings:LookupSettings",
        role="baseline",
        title=lambda name, settings: f"{settings['context']}-state mean",
    ),
    "mean": Family(
        "visualspeech.models.mean", reads=False, role="baseline", title=lambda name, settings: "training mean"
    ),
    # Not trained: the true parameters as if they were a prediction. Its error is that of the visual coding alone.
    "reconstruction": Family("", reads=False, role="floor", title=lambda name, settings: "reconstruction (floor)"),
}

#: Rows that every system has: what a prediction must beat, and the error that none can fall below.
ALWAYS = {"training_mean": {"family": "mean"}, "reconstruction": {"family": "reconstruction"}}

#: Keys of an entry of ``models:`` beside the settings of its family.
ENTRY_KEYS = ("family", "like", "from", "reads", "training", "title", "suffix", "seeds")


def family_named(name: str, where: str) -> Family:
    """The family of that name.

    Raises
    ------
    SettingError
        There is none.
    """
    if name not in FAMILIES:
        raise SettingError(
            f"`{where}.family: {name}` is unknown. Known: {', '.join(FAMILIES)}."
            + did_you_mean(str(name), list(FAMILIES))
        )
    return FAMILIES[name]


def expand(models: Mapping, blocks: Mapping, training: Mapping, seeds: Sequence[int], where: str) -> list[ModelRow]:
    """The rows of a system, in the order of the result tables, all settings filled in.

    Parameters
    ----------
    models : the system's ``models:``: key -> entry, or None to leave an inherited entry out
    blocks : names of its input blocks
    training : the system's settings of training, which an entry's own change
    seeds : of repetitions; the first one is not part of a row's name
    where : place of ``models`` in the settings, for messages

    Raises
    ------
    SettingError
        An entry is mistaken, or two rows have one name.
    """
    given = {key: dict(entry) for key, entry in models.items() if entry is not None}
    merged = {key: _inherited(key, given, f"{where}.{key}") for key in given}
    rows: dict[str, ModelRow] = {}
    for key, entry in {**merged, **{key: entry for key, entry in ALWAYS.items() if key not in merged}}.items():
        for row in _rows_of(key, entry, blocks, training, seeds, f"{where}.{key}"):
            if row.name in rows:
                raise SettingError(f"`{where}.{key}`: two rows are named {row.name}; give one a `suffix`.")
            rows[row.name] = row
    for row in rows.values():
        if row.parent and row.parent not in rows:
            raise SettingError(f"`{where}.{row.group}.from: {row.parent}` is no row. Known: {', '.join(rows)}.")
    order = {"model": 0, "baseline": 1, "floor": 2}
    return sorted(rows.values(), key=lambda row: order[row.role])


def _inherited(key: str, models: Mapping, where: str, seen: tuple[str, ...] = ()) -> dict:
    """An entry with what it takes over from the entry named by ``like`` or ``from``."""
    entry = models[key]
    above = entry.get("like") or entry.get("from")
    if not above:
        return entry
    if above in (*seen, key):
        raise SettingError(f"`{where}`: `like` and `from` lead back to {above}.")
    if above not in models:
        raise SettingError(
            f"`{where}`: {above!r} is no entry of `models`. Known: {', '.join(models)}."
            + did_you_mean(above, list(models))
        )
    base = {k: v for k, v in _inherited(above, models, where, (*seen, key)).items() if k not in ("like", "from")}
    base.pop("title", None)
    training = {**base.get("training", {}), **entry.get("training", {})}
    return {**base, **entry, **({"training": training} if training else {})}


def _rows_of(key: str, entry: Mapping, blocks, training: Mapping, seeds: Sequence[int], where: str) -> list[ModelRow]:
    if "family" not in entry:
        raise SettingError(f"`{where}` lacks `family`. Known: {', '.join(FAMILIES)}.")
    family = family_named(entry["family"], where)
    own = {name: value for name, value in entry.items() if name not in ENTRY_KEYS}
    cls = settings_class(family.settings) if family.settings else None
    known = [one.name for one in dataclass_fields(cls) if one.name != "seed"] if cls else []
    for name in own:
        if name not in known:
            raise SettingError(
                f"unknown setting `{where}.{name}`.{did_you_mean(name, known)} Known here: "
                f"{', '.join([*ENTRY_KEYS, *known])}."
            )
    reads = tuple(entry.get("reads", ()))
    for name in reads:
        if name not in blocks:
            raise SettingError(
                f"`{where}.reads`: {name!r} is no input block of the system. Known: {', '.join(blocks)}."
                + did_you_mean(str(name), list(blocks))
            )
    if family.reads and not reads:
        raise SettingError(f"`{where}.reads` must name the input blocks that the model reads: {', '.join(blocks)}.")
    if reads and not family.reads:
        raise SettingError(f"`{where}.reads` must be left out: the family {entry['family']} reads no input block.")
    if "training" in entry and not family.trained:
        raise SettingError(f"`{where}.training`: the family {entry['family']} is not trained by the training loop.")
    grid = [name for name in family.grid if isinstance(own.get(name), list | tuple)]
    for name in grid:
        if not own[name]:
            raise SettingError(f"`{where}.{name}: []` must have at least one entry.")
    seeded = list(entry.get("seeds", seeds)) if family.trained else list(seeds)[:1]
    rows = []
    for number, seed in enumerate(seeded):
        for values in product(*(own[name] for name in grid)):
            try:
                settings = with_defaults(cls, {**own, **dict(zip(grid, values, strict=True))}, ("seed",)) if cls else {}
                trained = _training({**training, **entry.get("training", {})}) if family.trained else {}
            except SettingError as error:
                raise SettingError(f"`{where}`: {error}") from error
            cell = (family.cell(settings) if grid else key) + (f"-{entry['suffix']}" if entry.get("suffix") else "")
            rows.append(
                ModelRow(
                    name=cell if number == 0 else f"{cell}-s{seed}",
                    title=entry.get("title") or family.title(cell, settings),
                    family=entry["family"],
                    settings=settings,
                    reads=reads,
                    training=trained,
                    seed=seed,
                    group=key,
                    cell=cell,
                    parent=entry.get("from", ""),
                    role=family.role,
                )
            )
    return rows


def _training(given: Mapping) -> dict:
    settings = training_settings(given)
    return {name: getattr(settings, name) for name in training_fields() if name != "seed"}


def load_model(path: str | Path):
    """Read a trained model of any family.

    Raises
    ------
    StorageError
        It is no model of this project.
    """
    _, settings = read_model_of(path, "trained model", ["model"])
    family = FAMILIES.get(settings.get("family"))
    if family is None or not family.module:
        raise StorageError(f"{path} is a model of the unknown family {settings.get('family')!r}.")
    return import_module(family.module).load(path)
