"""What a result was made from: digests of code, settings and splits."""

import ast
import hashlib
import json
import os
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

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
    reached: set[Path] = set()
    waiting = [Path(script).resolve(), *(_module(name) for name in modules)]
    while waiting:
        path = waiting.pop()
        if path not in reached:
            reached.add(path)
            waiting.extend(_imported(path))
    syntax = [(path.name, _syntax(path)) for path in reached]
    files = {file for path in reached for file in _data(path)} | set(map(Path, data))
    return digest(sorted(syntax) + sorted((file.name, file_digest(file)) for file in files))


def _module(name: str) -> Path:
    parts = name.split(".")
    path = PACKAGE.joinpath(*parts[1:])
    return path / "__init__.py" if path.is_dir() else path.with_suffix(".py")


@cache
def _syntax(path: Path) -> str:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            first = node.body[0] if node.body else None
            if (
                isinstance(first, ast.Expr)
                and isinstance(first.value, ast.Constant)
                and isinstance(first.value.value, str)
            ):
                node.body = node.body[1:]
    return hashlib.sha256(ast.dump(tree).encode()).hexdigest()


@cache
def _data(path: Path) -> tuple[Path, ...]:
    """The files of every folder beside a module that the module names and that is not a package."""
    named = {node.value for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if _is_name(node)}
    folders = (path.parent / name for name in sorted(named))
    found = (folder for folder in folders if folder.is_dir() and not (folder / "__init__.py").exists())
    return tuple(file for folder in found for file in sorted(folder.rglob("*")) if file.is_file())


def _is_name(node: ast.AST) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value.isidentifier()


@cache
def _imported(path: Path) -> tuple[Path, ...]:
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            names.add(node.module)
            names.update(f"{node.module}.{alias.name}" for alias in node.names)
    found = set()
    for name in names:
        parts = name.split(".")
        if parts[0] != PACKAGE.name:
            continue
        for end in range(1, len(parts) + 1):
            module = PACKAGE.joinpath(*parts[1:end])
            for candidate in (module.with_suffix(".py"), module / "__init__.py"):
                if candidate.is_file():
                    found.add(candidate)
    return tuple(sorted(found))
