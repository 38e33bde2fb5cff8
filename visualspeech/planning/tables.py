"""The tables of a system: the rows that their settings name."""

from collections.abc import Mapping, Sequence

from visualspeech.evaluation.metrics import METRICS
from visualspeech.evaluation.own_metrics import OWN_MARK
from visualspeech.models.rows import ModelRow
from visualspeech.schema import unknown

#: Kind of visual coding with regions, and the measures of it that are none of a region.
REGIONAL_KIND, OF_ANY = "markers", ("gv_ratio",)

#: Keys of tables and selections that name measures.
_METRICS = ("metrics", "intervals")
#: Names of tables that a selection cannot have.
TABLES = ("objective", "topologies", "comparisons", "articulation", "resting", "gains", "ablation", "regions",
          "emotions")  # fmt: skip


def table_mistakes(tables: Mapping, known: Sequence[str], where: str) -> list[str]:
    """What is wrong with the models that tables name, a sentence for each mistake.

    Parameters
    ----------
    tables : settings of the tables of a system, defaults filled in
    known : entries of its models, and rows
    where : place of ``tables`` in the settings, for messages
    """
    selections = {name: one for name, one in tables["selections"].items() if one is not None}
    named = {
        "topologies": tables["topologies"],
        **{f"{name}.rows": tables[name]["rows"] for name in ("regions", "emotions", "latex")},
        **{f"gains.{name}": names for name, names in tables["gains"].items()},
        **{f"ablation.rows.{name}": names or () for name, names in tables["ablation"]["rows"].items()},
        **{f"selections.{name}.rows": one["rows"] for name, one in selections.items()},
    }
    found = [
        unknown(f"{where}.{key}.{number}", name, known, "entry of `models` and no row")
        for key, names in named.items()
        for number, name in enumerate(names)
        if name not in known
    ]
    found += [
        unknown(f"{where}.selections.{name}.reference", one["reference"], one["rows"], "row of this table")
        for name, one in selections.items()
        if one["reference"] and one["reference"] not in one["rows"]
    ]
    found += [
        f"`{where}.selections.{name}`: {name} is the name of another table; give this one another."
        for name in selections
        if name in TABLES
    ]
    shown = {name for one in (tables, *selections.values()) for key in _METRICS for name in one.get(key, ())}
    found += [
        f"`{where}.latex.metrics.{number}: {name}` is in no table of the system; add it to `{where}.metrics`."
        for number, name in enumerate(tables["latex"]["metrics"])
        if name not in shown
    ]
    columns = len(tables["ablation"]["columns"])
    return found + [
        f"`{where}.ablation.rows.{name}` names {len(names)} models; it must name one for each of the {columns} "
        "`columns`, of which there must be two at least."
        for name, names in tables["ablation"]["rows"].items()
        if names is not None and (len(names) != columns or columns < 2)
    ]


def coding_mistakes(tables: Mapping, kind: str, where: str) -> list[str]:
    """What tables ask for that a visual coding does not have, a sentence for each mistake.

    Parameters
    ----------
    tables : settings of the tables of a system, resolved
    kind : of its visual coding
    where : place of ``tables`` in the settings, for messages
    """
    regional = kind == REGIONAL_KIND
    known = [one.name for one in METRICS.values() if bool(one.region) == regional or one.name in OF_ANY]
    asked = {"metrics": tables["metrics"]}
    for name, one in tables["selections"].items():
        asked |= {f"selections.{name}.{key}": one[key] for key in ("metrics", "intervals") if one["rows"]}
    found = [
        f"`{where}.{key}`: {', '.join(wrong)} {'is no measure' if len(wrong) == 1 else 'are no measures'} of a visual "
        f"coding of the kind {kind}. Its measures are: {', '.join(known)}."
        for key, names in asked.items()
        if (wrong := [name for name in names if name not in known and OWN_MARK not in name])
    ]
    needless = {
        "topologies": regional and tables["topologies"],
        "gains": regional and tables["gains"]["candidates"],
        "regions": not regional and tables["regions"]["rows"],
        "emotions": not regional and tables["emotions"]["rows"],
    }
    return found + [
        f"`{where}.{name}`: there is no such table for a visual coding of the kind {kind}; leave it empty."
        for name, given in needless.items()
        if given
    ]


def resolved_tables(tables: Mapping, rows: Sequence[ModelRow]) -> dict:
    """Settings of tables that name rows in place of entries of ``models``."""
    return {
        **tables,
        "topologies": rows_of_entries(tables["topologies"], rows),
        **{
            name: {**tables[name], "rows": rows_of_entries(tables[name]["rows"], rows)}
            for name in ("regions", "emotions")
        },
        "latex": {**tables["latex"], "rows": _with_cells(tables["latex"]["rows"], rows)},
        "gains": {key: rows_of_entries(names, rows) for key, names in tables["gains"].items()},
        "ablation": {**tables["ablation"], "rows": _ablation(tables["ablation"], rows)},
        "selections": {name: _selection(one, rows) for name, one in tables["selections"].items() if one is not None},
    }


def _selection(selection: Mapping, rows: Sequence[ModelRow]) -> dict:
    """A table of chosen rows, whose reference is the cell that its rows are pooled to."""
    cells = {row.name: row.cell or row.name for row in rows}
    reference = next(iter(rows_of_entries(filter(None, [selection["reference"]]), rows)), "")
    return {**selection, "rows": rows_of_entries(selection["rows"], rows), "reference": cells.get(reference, "")}


def _with_cells(names: Sequence[str], rows: Sequence[ModelRow]) -> list[str]:
    """Names of the rows that entries ask for, and of the cells that tables pool them to."""
    # The last is the name of the row in the table of each seed.
    own = {row.name: (row.name, cell := row.cell or row.name, f"{cell}-s{row.seed}") for row in rows}
    return list(dict.fromkeys(one for name in rows_of_entries(names, rows) for one in own[name]))


def rows_of_entries(names: Sequence[str], rows: Sequence[ModelRow]) -> list[str]:
    """Names of the rows that entries of ``models`` ask for; an entry that the system leaves out asks for none."""
    return [row.name for name in names for row in rows if name in (row.group, row.name)]


def _ablation(ablation: Mapping, rows: Sequence[ModelRow]) -> dict[str, list[str]]:
    """Heading -> cell of the model in each column, of the rows of the ablation table whose models the system has.

    Of entries with several models, those with equal settings are compared; each such row is named after its models.
    """
    result = {}
    for heading, names in ablation["rows"].items():
        found = [
            list({row.cell: row for row in rows if name in (row.group, row.name)}.values()) for name in names or ()
        ]
        alone = all(len(models) == 1 for models in found)
        for first in found[0] if found else ():
            equal = [[row.cell for row in models if alone or row.settings == first.settings] for models in found]
            if all(len(cells) == 1 for cells in equal):
                cells = [cell for (cell,) in equal]
                result[heading if len(found[0]) == 1 else f"{heading}: {' / '.join(cells)}"] = cells
    return result
