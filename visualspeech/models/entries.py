"""The entries of a system's ``models:``: their keys, what they take over from each other, their mistakes."""

from collections.abc import Collection, Iterator, Mapping
from itertools import chain, product
from types import MappingProxyType

from visualspeech.errors import SettingError
from visualspeech.fields import MAX_SEED, FieldError, section_schema, with_defaults
from visualspeech.models.families import FAMILIES, Family
from visualspeech.models.reads import read_mistakes, read_names, read_windows
from visualspeech.models.training_settings import TrainingSettings
from visualspeech.schema import mistakes, settings_class, unknown
from visualspeech.settings import merged as laid_over

#: Keys of an entry of ``models:`` beside the settings of its family, as JSON Schema.
ENTRY = {
    "family": {"type": "string", "description": "Family of models, which the settings of the entry belong to."},
    "like": {"type": "string", "maxLength": 64,
             "description": "Entry of `models` whose keys count where this one has none."},
    "from": {"type": "string", "maxLength": 64,
             "description": "As `like`, and training starts from the model of that entry; of a family that changes "
                            "the predictions of others: the row or entry whose predictions are changed."},
    "reads": {"type": "array", "uniqueItems": True, "maxItems": 200,
              "items": {"description": "Input block of the system."},
              "description": "Input blocks of the system that the model reads, in this order; `{block: seconds}` reads "
                             "a window of that length before and after each frame too."},
    "title": {"type": "string", "minLength": 1, "maxLength": 200, "pattern": "^[^\\r\\n]*\\Z",
              "description": "Name in tables."},
    "suffix": {"type": "string", "pattern": "^[A-Za-z0-9_-]{1,32}\\Z",
               "description": "At most 32 letters, digits, - and _ that follow the names of the rows, after a hyphen."},
    "training": {"type": "object", "description": "What differs from the system's settings of training."},
    "seeds": {"type": "array", "uniqueItems": True, "minItems": 1, "maxItems": 100,
              "items": {"type": "integer", "minimum": 0, "maximum": MAX_SEED,
                        "description": "Seed of weights, order and dropout."},
              "description": "Seeds of the networks of this entry, in place of the system's."},
}  # fmt: skip
ENTRY_KEYS = tuple(ENTRY)


def entry_schema(family: str, entry: Mapping = MappingProxyType({}), blocks: Collection[str] = ()) -> dict:
    """JSON Schema of an entry of ``models:``; no key is required.

    Parameters
    ----------
    family : its name in :data:`FAMILIES`
    entry : what is held against the schema: settings of the grid that it gives as lists may be lists
    blocks : names of the system's input blocks
    """
    known = FAMILIES[family]
    common = {key: value for key, value in ENTRY.items() if known.trained or key not in TRAINED_KEYS}
    common["family"] = _family_schema()
    least, most = known.reads
    common["reads"] = {**ENTRY["reads"], "items": {**ENTRY["reads"]["items"], "enum": list(blocks)}, "minItems": least}
    common["reads"] |= {} if most is None else {"maxItems": most}
    if known.trained:
        common["training"] = section_schema(TrainingSettings, ENTRY["training"]["description"], ("seed",))
    own = section_schema(settings_class(known.settings), hidden=("seed",))["properties"] if known.settings else {}
    for name in known.grid:
        if isinstance(entry.get(name), list):
            several = {"type": "array", "minItems": 1, "maxItems": 20, "uniqueItems": True, "items": own[name]}
            own[name] = {"description": own[name]["description"], **several}
    return {"type": "object", "additionalProperties": False, "properties": common | own}


def _family_schema() -> dict:
    return {"enum": list(FAMILIES), "description": ENTRY["family"]["description"]}


#: Keys of entries whose family is trained by :mod:`visualspeech.models.training`.
TRAINED_KEYS = ("training", "seeds")


def model_mistakes(models: Mapping, blocks: Collection[str], where: str) -> list[str]:
    """What is wrong with the entries of ``models:``, a sentence for each mistake.

    An inherited key is judged where it is written. Entries that are no mappings are left to the system's schema.

    Parameters
    ----------
    models, blocks, where : as for :func:`expand`
    """
    given = {key: dict(entry) for key, entry in models.items() if isinstance(entry, Mapping)}
    links = {key: _link_mistakes(key, given, f"{where}.{key}") for key in given}
    # What takes over from a broken entry is not judged: its mistakes would be those of the entry above again.
    sound = [key for key in given if not any(links.get(name) for name in _chain(key, given))]
    for key in sorted(sound, key=lambda name: len(_chain(name, given))):
        if any(links.get(name) for name in _chain(key, given)):
            continue
        links[key] = _family_mistakes(key, given, f"{where}.{key}")
    sound = [key for key in sound if not any(links.get(name) for name in _chain(key, given))]
    found = list(chain.from_iterable(links.values()))
    found += [said for key in sound for said in _key_mistakes(key, given, blocks, f"{where}.{key}")]
    return found or [said for key in sound for said in _settings_mistakes(key, given, f"{where}.{key}")]


def _chain(key: str, models: Mapping) -> list[str]:
    """An entry and those that it takes over from, one after the other; a chain that leads back ends there."""
    names = [key]
    while True:
        above = _above(names[-1], models)[1]
        if not isinstance(above, str) or above in names:
            return names
        names.append(above)


def _above(key: str, models: Mapping) -> tuple[str, str | None]:
    """The key by which an entry takes over from another one (``like``, ``from``), and the name of that one."""
    entry = models.get(key, {})
    if "like" in entry:
        return "like", entry["like"]
    if "from" in entry and not _is_made_from_rows(key, models):
        return "from", entry["from"]
    return "", None


def _is_made_from_rows(key: str, models: Mapping) -> bool:
    """Whether ``from`` of an entry names finished rows of any family, of which it takes over nothing."""
    seen, entry = [key], models.get(key, {})
    while "family" not in entry and isinstance(entry.get("like"), str) and entry["like"] not in seen:
        seen.append(entry["like"])
        entry = models.get(entry["like"], {})
    family = entry.get("family")
    return isinstance(family, str) and family in FAMILIES and FAMILIES[family].made_of == "from"


def _link_mistakes(key: str, models: Mapping, where: str) -> list[str]:
    """What is wrong with the keys ``like`` and ``from`` of an entry."""
    own = models[key]
    found = mistakes(own, {"type": "object", "properties": {name: ENTRY[name] for name in ("like", "from")}}, where)
    from_rows = _is_made_from_rows(key, models)
    if "like" in own and "from" in own and not from_rows:
        found.append(f"`{where}` has both `like` and `from`; `from` takes over settings too, so leave `like` out.")
    for name in ("like", "from") if not found else ():
        above = own.get(name)
        if name == "from" and from_rows:
            continue  # it may be a row, so that it is looked for among the rows
        if above is not None and above not in models:
            others = [other for other in models if other != key]
            found.append(unknown(f"{where}.{name}", above, others, "entry of `models`"))
        elif above is not None and _is_first_of_loop(key, models):
            found.append(f"`{where}.{name}: {above}` leads back to {key}; name another entry.")
    return found


def _is_first_of_loop(key: str, models: Mapping) -> bool:
    """Whether an entry's chain leads back to it, and it is the first one of that chain in the settings."""
    names = _chain(key, models)
    return _above(names[-1], models)[1] == key and key == next(name for name in models if name in names)


def _family_mistakes(key: str, models: Mapping, where: str) -> list[str]:
    """What is wrong with the family of an entry, and with the family of the one that it takes over from."""
    own, entry = models[key], inherited(key, models)
    link, named = _above(key, models)
    if "family" not in entry:
        known = f"{ENTRY['family']['description']} Known: {', '.join(FAMILIES)}."
        return [] if link else [f"`{where}` lacks `family`. {known}"]
    found = mistakes(entry["family"], _family_schema(), f"{where}.family")
    if found:
        return found if "family" in own else []
    if not link:
        return []
    above = inherited(named, models)
    if above.get("family", entry["family"]) != entry["family"]:
        family = f"`{where}.family: {entry['family']}`"
        return [f"{family} must be {above['family']}, the family of the entry that `{link}` names."]
    grid = grid_of(FAMILIES[entry["family"]], above)
    if link == "from" and grid:
        return [
            f"`{where}.from: {own['from']}` asks for a model for each of its {' and '.join(grid)}, and a model is made "
            "from one alone. Name an entry without lists."
        ]
    return []


def _key_mistakes(key: str, models: Mapping, blocks: Collection[str], where: str) -> list[str]:
    """What is wrong with the keys of an entry, one by one; inherited ones are judged where they are written."""
    own, entry, found = models[key], inherited(key, models), []
    family = FAMILIES[entry["family"]]
    if not family.trained:
        found = [
            f"`{where}.{name}` is for networks; the family {entry['family']} is trained in another way. Leave it out."
            for name in TRAINED_KEYS
            if name in own
        ]
        own = {name: value for name, value in own.items() if name not in TRAINED_KEYS}
    if family.reads[1] == 0 and "reads" in own:
        read = f"what the rows read that `{family.made_of}` names" if family.made_of else "no input block"
        found.append(f"`{where}.reads` must be left out: the family {entry['family']} reads {read}.")
        own = {name: value for name, value in own.items() if name != "reads"}
    if isinstance(own.get("reads"), list):
        of_form = read_mistakes(own["reads"], f"{where}.reads")
        named = {} if of_form else {"reads": read_names(own["reads"])}
        found, own = found + of_form, {name: value for name, value in own.items() if name != "reads"} | named
    found += mistakes(own, entry_schema(entry["family"], own, blocks), where)
    if family.reads[0] and "reads" not in entry:
        found.append(f"`{where}` lacks `reads`. {ENTRY['reads']['description']} Known: {', '.join(blocks)}.")
    return found


def _settings_mistakes(key: str, models: Mapping, where: str) -> list[str]:
    """What does not go together in an entry whose keys, one by one, are right."""
    entry, found = inherited(key, models), []
    family = FAMILIES[entry["family"]]
    # It may have the settings of the entry above, where their mistakes are reported, with other blocks.
    own = bool(_own(models[key])) or "family" in models[key]
    if not own and "reads" not in models[key]:
        return []
    for settings in combinations(family, entry):
        try:
            built = family_settings(family, settings, where, entry)
        except SettingError as error:
            found += [str(error)] if own else []
            continue
        if (reason := family.no_windows(built)) and read_windows(entry.get("reads", ())):
            found.append(f"`{where}.reads` has a window; {reason}")
        if family.made_from(built) and not entry.get("from"):
            others = ", ".join(name for name in models if name != key)
            found.append(f"`{where}` lacks `from`: with these settings a model is made from another. Known: {others}.")
    return list(dict.fromkeys(found))


def inherited(key: str, models: Mapping) -> dict:
    """An entry with what it takes over from the entry named by ``like`` or ``from``; no chain leads back to itself."""
    entry = models[key]
    above = _above(key, models)[1]
    if above is None:
        return entry
    # What is like a model that is made from another is made from that one too.
    dropped = ("title", "like", "from") if "from" in entry else ("title", "like")
    base = {name: value for name, value in inherited(above, models).items() if name not in dropped}
    training = [one["training"] for one in (base, entry) if isinstance(one.get("training"), Mapping)]
    return {**base, **entry, **({"training": laid_over(*training)} if len(training) == 2 else {})}


def _own(entry: Mapping) -> dict:
    """The settings of an entry's family."""
    return {name: value for name, value in entry.items() if name not in ENTRY}


def grid_of(family: Family, entry: Mapping) -> list[str]:
    """Settings of an entry that are lists of values, each of which asks for a row."""
    return [name for name in family.grid if isinstance(entry.get(name), list | tuple)]


def combinations(family: Family, entry: Mapping) -> Iterator[dict]:
    """Settings of the family for each row of an entry."""
    own, grid = _own(entry), grid_of(family, entry)
    for values in product(*(own[name] for name in grid)):
        yield {**own, **dict(zip(grid, values, strict=True))}


def family_settings(family: Family, own: Mapping, where: str, entry: Mapping) -> dict:
    """All settings of a row of an entry; where a list holds the value at fault, the message says its position."""
    if not family.settings:
        return {}
    cls = settings_class(family.settings)
    try:
        return with_defaults(cls, own, ("seed",))
    except FieldError as error:
        moved = error.at(cls.section, where)
        name = moved.key.removeprefix(f"{where}.")
        if name in grid_of(family, entry):
            moved.key += f".{list(entry[name]).index(own[name])}"
        raise FieldError(moved.key, moved.rest) from None
