"""What a result was made from: digests of code, settings and splits."""

import ast
import hashlib
import json
import os
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import NamedTuple

PACKAGE = Path(__file__).resolve().parent


def digest(value) -> str:
    """Short digest of anything that JSON can hold; the order of a mapping's keys does not matter."""
    return hashlib.sha256(json.dumps(value, sort_keys=True).encode()).hexdigest()[:12]


def file_digest(path: str | Path) -> str:
    """Short digest of a file's bytes."""
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()[:12]


def commit() -> str:
    """Commit of the checkout that holds this package, marked as dirty where files differ; empty outside a checkout."""
    import subprocess

    describe = ["git", "-C", str(PACKAGE), "describe", "--always", "--dirty"]
    try:
        done = subprocess.run(describe, capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return ""
    return done.stdout.strip()


def command() -> str:
    """Command line of the run that a job belongs to (:func:`visualspeech.jobs.settle_environment`)."""
    return os.environ.get("VISUALSPEECH_COMMAND", "")


def split_hash(split: Mapping[str, str]) -> str:
    """Digest of a split (id -> train, validation or test); every table prints it."""
    return digest(sorted(split.items()))


def code_digest(script: str | Path, *modules: str, data: Iterable[str | Path] = ()) -> str:
    """Digest of a script and of every module of this package that it imports, without docstrings and comments.

    Imports inside the package are followed with :mod:`ast`, also those inside functions, so a rule runs again when code
    that it uses changes and not when other code does. Data files of the package (templates, published figures) are
    included with the modules that name their folder.

    Parameters
    ----------
    modules : dotted names of further modules of this package, which the script imports by name at run time
    data : further files that the script reads
    """
    reached: dict[Path, _Module] = {}
    waiting = [Path(script).resolve(), *(_module(name) for name in modules)]
    while waiting:
        path = waiting.pop()
        if path not in reached:
            reached[path] = _read(path)
            waiting.extend(reached[path].imports)
    syntax = sorted((path.name, module.syntax) for path, module in reached.items())
    files = {file for module in reached.values() for file in module.data} | set(map(Path, data))
    return digest(syntax + sorted((file.name, file_digest(file)) for file in files))


class _Module(NamedTuple):
    """Digest of a module's syntax, the modules of this package that it imports, and the data files that it names."""

    syntax: str
    imports: tuple[Path, ...]
    data: tuple[Path, ...]


def _module(name: str) -> Path:
    parts = name.split(".")
    path = PACKAGE.joinpath(*parts[1:])
    return path / "__init__.py" if path.is_dir() else path.with_suffix(".py")


@cache
def _read(path: Path) -> _Module:
    """The module at a path, read once per process: the jobs of a plan reach the same modules."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    imported: set[str] = set()
    named: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            imported.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            imported.add(node.module)
            imported.update(f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Constant):
            if isinstance(node.value, str) and node.value.isidentifier():
                named.add(node.value)
        elif isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            if _is_docstring(node.body[0] if node.body else None):
                node.body = node.body[1:]
    syntax = hashlib.sha256(ast.dump(tree).encode()).hexdigest()
    files = {file for name in imported for file in _files(name)}
    return _Module(syntax, tuple(sorted(files)), _data(path.parent, named))


def _is_docstring(node: ast.AST | None) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)


@cache
def _files(name: str) -> tuple[Path, ...]:
    """Files of this package that are run when ``name``, a module or something in one, is imported."""
    package, *parts = name.split(".")
    if package != PACKAGE.name:
        return ()
    modules = [PACKAGE.joinpath(*parts[:end]) for end in range(len(parts) + 1)]
    candidates = (file for module in modules for file in (module.with_suffix(".py"), module / "__init__.py"))
    return tuple(file for file in candidates if file.is_file())


def _data(folder: Path, names: set[str]) -> tuple[Path, ...]:
    """The files of every folder beside a module that it names and that is no package."""
    folders = (folder / name for name in sorted(names))
    found = (one for one in folders if one.is_dir() and not (one / "__init__.py").exists())
    return tuple(file for one in found for file in sorted(one.rglob("*")) if file.is_file())
