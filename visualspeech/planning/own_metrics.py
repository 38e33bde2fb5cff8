"""Measures of the user's own, ``module:function`` among the metrics of tables: found and described before any job.

The source is read, not run: a job imports it. What is needed of a measure (its title, its direction, what it takes)
follows from its ``def``, its docstring and attributes that are set on the function.
"""

import ast
import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from visualspeech.errors import SettingError, plain_reason
from visualspeech.evaluation.metrics import METRICS
from visualspeech.evaluation.own_metrics import GIVEN, OWN_MARK
from visualspeech.provenance import digest
from visualspeech.schema import did_you_mean, unknown

MAX_BYTES = 1_000_000  # of a module
#: Directions in which figures are better, of :class:`visualspeech.evaluation.metrics.Metric`.
BEST = ("low", "high", "one", "zero")
#: Attribute of the function -> its default and the number of characters that it may have.
ATTRIBUTES = {"title": ("", 100), "unit": ("", 20), "best": ("low", 4)}
DOCS = "docs/tables.md"


def metric_mistakes(tables, where: str) -> list[str]:
    """What is wrong with the names of measures in the settings of tables, a sentence for each mistake.

    Parameters
    ----------
    tables : settings of the tables of a system as given; of what is no list of texts, its schema says so
    where : their place in the settings, for messages
    """
    found = []
    for key, names in _named(tables):
        for number, name in enumerate(names):
            place = f"{where}.{key}.{number}"
            if OWN_MARK not in name:
                found += [] if name in METRICS else [_no_measure(place, name)]
                continue
            try:
                described(name, place)
            except SettingError as error:
                found.append(str(error))
    return found


def own_metrics(tables: Mapping) -> dict[str, dict]:
    """Description of each measure of the user's own that tables name, by name (:func:`described`)."""
    names = dict.fromkeys(name for _, named in _named(tables) for name in named if OWN_MARK in name)
    return {name: described(name, "tables.metrics") for name in names}


def described(name: str, where: str) -> dict:
    """A measure of the user's own as plain data.

    Parameters
    ----------
    name : ``module:function``; the module is a name, found in the working folder or where Python finds modules, or the
        path of a file that ends in ``.py``
    where : its place in the settings, for messages

    Returns
    -------
    ``file``, ``root`` and ``module``, by which a job imports it; ``function``; ``takes``, what it asks for beside
    prediction and truth; ``title``, ``unit``, ``best`` and ``definition``; ``digest`` of its source and of the modules
    beside it that it imports.

    Raises
    ------
    SettingError
        There is no such module or function, it cannot be read, or it takes or says what a measure cannot.
    """
    place = f"`{where}: {name}`"
    module, _, function = name.rpartition(OWN_MARK)
    file, root, dotted = _located(module, place)
    tree = _parsed(file, place)
    defined = {one.name: one for one in tree.body if isinstance(one, ast.FunctionDef)}
    if function not in defined:
        listed = f" It defines: {', '.join(defined)}." if defined else " It defines no function."
        raise SettingError(
            f"{place}: {file} has no `def {function}(predicted, true)`.{did_you_mean(function, list(defined))}{listed}"
        )
    node = defined[function]
    first = " ".join((ast.get_docstring(node) or "").split("\n\n")[0].split()).rstrip(".")
    said = _attributes(tree, function, place)
    return {
        "file": _relative(file),
        "root": _relative(root),
        "module": dotted,
        "function": function,
        "takes": _taken(node, place),
        "title": said["title"] or function.replace("_", " ").strip().capitalize(),
        "unit": said["unit"],
        "best": said["best"],
        "definition": (first or f"the function {function} of {file.name}")
        + "; mean over utterances of the figure of each",
        "digest": digest(_sources(file, root)),
    }


def _named(tables) -> Iterator[tuple[str, list[str]]]:
    """The lists of measures in the settings of tables, each with its key."""
    if not isinstance(tables, Mapping):
        return
    selections = tables.get("selections")
    latex = tables.get("latex")
    given = {"metrics": tables.get("metrics")}
    given |= {"latex.metrics": latex.get("metrics")} if isinstance(latex, Mapping) else {}
    for name, one in (selections if isinstance(selections, Mapping) else {}).items():
        if isinstance(one, Mapping):
            given |= {f"selections.{name}.{key}": one.get(key) for key in ("metrics", "intervals")}
    for key, names in given.items():
        if isinstance(names, list | tuple) and all(isinstance(one, str) for one in names):
            yield key, list(names)


def _no_measure(place: str, name: str) -> str:
    return f"{unknown(place, name, list(METRICS), 'measure')} Or `module:function`, a measure of your own ({DOCS})."


def _located(module: str, place: str) -> tuple[Path, Path, str]:
    """File of a module, the folder that its name counts from, and that name with dots."""
    if module.endswith(".py"):
        path = Path(module).expanduser()
        if not path.is_file():
            raise SettingError(f"{place}: there is no file {path}. A relative path counts from the working folder.")
        if not path.stem.isidentifier():
            raise SettingError(f"{place}: {path.name} is no possible name of a Python module; rename the file.")
        return path, path.parent, path.stem
    parts = module.split(".")
    if not all(part.isidentifier() for part in parts):
        raise SettingError(f"{place} must be `module:function` or `path/file.py:function` ({DOCS}).")
    for root in map(Path, dict.fromkeys(one or "." for one in ("", *sys.path))):
        for path in (root.joinpath(*parts).with_suffix(".py"), root.joinpath(*parts, "__init__.py")):
            if path.is_file():
                return path, root, module
    raise SettingError(
        f"{place}: there is no module {module}: no {'/'.join(parts)}.py in the working folder {Path.cwd()}, nor where "
        "Python finds modules. Give the path of the file, ending in .py, or set PYTHONPATH."
    )


def _parsed(file: Path, place: str) -> ast.Module:
    try:
        if file.stat().st_size > MAX_BYTES:
            raise SettingError(f"{place}: {file} has more than {MAX_BYTES:,} bytes and is no module of measures.")
        return ast.parse(file.read_text(encoding="utf-8"))
    except SyntaxError as error:
        raise SettingError(f"{place}: {file}, line {error.lineno or 1} is no Python: {error.msg}.") from error
    except (OSError, ValueError, RecursionError, MemoryError) as error:
        raise SettingError(f"{place}: cannot read {file}: {plain_reason(error)}.") from error


def _taken(node: ast.FunctionDef, place: str) -> list[str]:
    """What a function asks for beside its first two parameters."""
    arguments = node.args
    positional = [one.arg for one in (*arguments.posonlyargs, *arguments.args)]
    optional = positional[len(positional) - len(arguments.defaults) :] if arguments.defaults else []
    optional += [
        one.arg for one, default in zip(arguments.kwonlyargs, arguments.kw_defaults, strict=True) if default is not None
    ]
    rest = [*positional[2:], *(one.arg for one in arguments.kwonlyargs)]
    wrong = [name for name in rest if name not in GIVEN and name not in optional]
    if len(positional) < 2 or wrong or len(arguments.posonlyargs) > 2:
        given = f"it takes `{wrong[0]}`" if wrong else "it does not take two arrays by position"
        raise SettingError(
            f"{place}: line {node.lineno} must be `def {node.name}(predicted, true)`, with any of "
            f"{', '.join(GIVEN)} after these; {given}.{did_you_mean(wrong[0], list(GIVEN)) if wrong else ''}"
        )
    return [name for name in rest if name in GIVEN]


def _attributes(tree: ast.Module, function: str, place: str) -> dict[str, str]:
    """What is set on a function after its definition: ``function.title = "..."``."""
    found = {name: default for name, (default, _) in ATTRIBUTES.items()}
    for node in tree.body:
        for target in node.targets if isinstance(node, ast.Assign) else ():
            if not (isinstance(target, ast.Attribute) and isinstance(target.value, ast.Name)):
                continue
            if target.value.id != function:
                continue
            name, key = target.attr, f"{place}: line {node.lineno}: `{function}.{target.attr}`"
            if name not in ATTRIBUTES:
                raise SettingError(
                    f"{key} is not known.{did_you_mean(name, list(ATTRIBUTES))} Known: {', '.join(ATTRIBUTES)}."
                )
            value = node.value.value if isinstance(node.value, ast.Constant) else None
            most = ATTRIBUTES[name][1]
            if name == "best" and value not in BEST:
                raise SettingError(f"{key} must be one of {', '.join(map(repr, BEST))}.")
            if not isinstance(value, str) or len(value) > most or not value.isprintable():
                raise SettingError(f"{key} must be a text in quotes, of one line and at most {most} characters.")
            found[name] = value
    return found


def _sources(file: Path, root: Path) -> list[list[str]]:
    """Name and syntax of a module and of all below the same folder that it imports, comments left out."""
    waiting, found = [file], {}
    while waiting:
        path = waiting.pop()
        if path in found:
            continue
        try:
            tree = ast.parse(path.read_text(encoding="utf-8"))
        except (OSError, ValueError, SyntaxError, RecursionError):
            continue  # a job that imports it says what is wrong
        found[path] = [os.path.relpath(path, root), digest(ast.dump(tree))]
        for node in ast.walk(tree):
            waiting += [one for names in _imported(node, path, root) for one in names if one.is_file()]
    return sorted(found.values())


def _imported(node: ast.AST, path: Path, root: Path) -> Iterator[Sequence[Path]]:
    """Files that an import may mean."""
    if isinstance(node, ast.Import):
        names, base = [one.name for one in node.names], root
    elif isinstance(node, ast.ImportFrom):
        base = path.parents[node.level - 1] if 0 < node.level <= len(path.parents) else root
        names = [".".join(filter(None, (node.module, one.name))) for one in node.names] + [node.module or ""]
    else:
        return
    for name in filter(None, names):
        parts = name.split(".")
        yield [base.joinpath(*parts).with_suffix(".py"), *(
            base.joinpath(*parts[:end], "__init__.py") for end in range(1, len(parts) + 1)
        )]  # fmt: skip


def _relative(path: Path) -> str:
    """A path as jobs find it: from the working folder where it lies there, so that moving that re-measures nothing."""
    whole = path.absolute()
    return str(whole.relative_to(Path.cwd())) if whole.is_relative_to(Path.cwd()) else str(whole)
