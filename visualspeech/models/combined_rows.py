"""Rows that are made of other rows: which ones, in which order they are planned, and mistakes in their names."""

from collections.abc import Mapping, Sequence

from visualspeech.errors import SettingError
from visualspeech.models.combined_settings import MAX_DEPTH, MAX_MEMBERS
from visualspeech.models.families import FAMILIES
from visualspeech.models.rows import ModelRow
from visualspeech.schema import unknown


def references(entry: Mapping) -> dict[str, str]:
    """What an entry is made of: its key in the entry (``from``, ``members.0``) -> name of an entry or a row."""
    named = {"from": entry["from"]} if "from" in entry else {}
    if FAMILIES[entry["family"]].made_of == "members":
        named |= {f"members.{number}": name for number, name in enumerate(entry.get("members", ()))}
    return named


def ready(models: Mapping[str, Mapping], made: Mapping[str, Sequence[ModelRow]], where: str) -> list[str]:
    """Entries without rows whose references have theirs; empty when all entries have rows.

    Parameters
    ----------
    models : all entries, complete
    made : rows of the entries that have theirs
    where : place of ``models`` in the settings, for messages

    Raises
    ------
    SettingError
        Names are unknown, or lead back to their own entry; a line for each.
    """
    waiting = {key: entry for key, entry in models.items() if key not in made}
    rows = {row.name for group in made.values() for row in group}
    # A name that is both an entry and a row means the entry, whose rows may not be there yet.
    open_names = {
        key: {at: name for at, name in references(entry).items() if name in waiting or name not in {*made, *rows}}
        for key, entry in waiting.items()
    }
    found = [key for key, names in open_names.items() if not names]
    if found or not waiting:
        return found
    known = [*models, *(name for name in rows if name not in models)]
    mistakes = [
        unknown(f"{where}.{key}.{at}", name, [one for one in known if one != key], "entry of `models` and no row")
        for key, names in open_names.items()
        for at, name in names.items()
        if name not in waiting
    ]
    if not mistakes:
        key, at = _loop(open_names)
        mistakes = [f"`{where}.{key}.{at}: {open_names[key][at]}` leads back to {key}; name another entry or row."]
    raise SettingError("\n".join(mistakes))


def _loop(names: Mapping[str, Mapping[str, str]]) -> tuple[str, str]:
    """An entry on a loop of references, all of which are entries, and the key of its reference that is on the loop."""
    path: list[str] = [next(iter(names))]
    while path[-1] not in path[:-1]:
        path.append(next(iter(names[path[-1]].values())))
    loop = path[path.index(path[-1]) :]
    first = next(key for key in names if key in loop)
    return first, next(iter(names[first]))


def named_rows(name: str, made: Mapping[str, Sequence[ModelRow]]) -> list[ModelRow]:
    """The rows of an entry, or the row of that name."""
    if name in made:
        return list(made[name])
    return [row for group in made.values() for row in group if row.name == name]


def members_of(
    entry: Mapping, made: Mapping[str, Sequence[ModelRow]], rows: Mapping[str, ModelRow], where: str
) -> list[list[ModelRow]]:
    """The rows that each row of an entry is made of, where its family is made of finished rows.

    Parameters
    ----------
    entry : complete
    made : rows by entry
    rows : all of these by name
    where : place of the entry in the settings, for messages

    Raises
    ------
    SettingError
        A name stands for what no row can be made of, or for too many rows; a line for each mistake.
    """
    found, mistakes = {}, []
    for at, name in references(entry).items():
        named = named_rows(name, made)
        mistakes += _mistakes(f"{where}.{at}", name, named, rows)
        found |= {row.name: row for row in named}
    if not found:
        mistakes.append(f"`{where}.members: []` must name at least one entry or row.")
    several = FAMILIES[entry["family"]].made_of == "members"
    if several and len(found) > MAX_MEMBERS:
        mistakes.append(f"`{where}.members` stands for {len(found)} rows; name entries of at most {MAX_MEMBERS}.")
    if not several and len({row.cell for row in found.values()}) > 1:
        cells = list(dict.fromkeys(row.cell for row in found.values()))
        shown = ", ".join(cells[:4]) + (", ..." if len(cells) > 4 else "")
        mistakes.append(f"`{where}.from: {entry['from']}` stands for several models ({shown}); name one of them.")
    if mistakes:
        raise SettingError("\n".join(mistakes))
    return [list(found.values())] if several else [[row] for row in found.values()]


def _mistakes(where: str, name: str, named: Sequence[ModelRow], rows: Mapping[str, ModelRow]) -> list[str]:
    said = []
    for row in named:
        if row.role == "floor":
            said.append(f"`{where}: {name}` is a floor, not a prediction; name a model.")
        elif not row.reads:
            said.append(f"`{where}: {name}` is a baseline that reads no input block; name a model.")
        elif _depth(row, rows) >= MAX_DEPTH:
            said.append(f"`{where}: {name}` is made of rows that are made of rows, more than {MAX_DEPTH} deep.")
    return list(dict.fromkeys(said))


def _depth(row: ModelRow, rows: Mapping[str, ModelRow]) -> int:
    """How deep rows are made of finished rows: 1 for a network, 2 for an ensemble of networks."""
    if not FAMILIES[row.family].made_of:
        return 1
    return 1 + max(_depth(rows[name], rows) for name in row.parents)


def reads_of(members: Sequence[ModelRow]) -> tuple[str, ...]:
    """Names of all input blocks that rows read, each once, in the order in which they come first."""
    return tuple(dict.fromkeys(name for row in members for name in row.reads))
