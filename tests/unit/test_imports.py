"""Imports go down only, without cycles; torch is imported by models alone; no module is too long to read."""

import ast
from pathlib import Path

import pytest

import visualspeech
from tests.paths import REPOSITORY

PACKAGE = Path(visualspeech.__file__).parent
#: From the ground up; a module imports its own layer and those below. The ground is the modules beside the packages.
LAYERS = (
    ("ground", "storage"),
    ("media",),
    ("corpora", "speech", "face"),
    ("features",),
    ("models",),
    ("animation", "evaluation"),
    ("study",),
    ("planning", "api"),
    ("cli",),
)
LEVELS = {name: level for level, names in enumerate(LAYERS) for name in names}
MAX_LINES = 400


def name_of(path):
    parts = (PACKAGE.name, *path.relative_to(PACKAGE).with_suffix("").parts)
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {name_of(path): path for path in sorted(PACKAGE.rglob("*.py"))}


def imported(path):
    """Every name that a module imports, anywhere in it, and the modules that these names are or lie in."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert not node.level, f"{path}: relative import"
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


GRAPH = {
    name: {other for other in imported(path) if other in MODULES and other != name} for name, path in MODULES.items()
}


def part_of(name):
    """The package that a module belongs to; the command line is on top of all, other modules beside them the ground."""
    parts = name.split(".")
    if len(parts) > 1 and (PACKAGE / parts[1]).is_dir():
        return parts[1]
    return "cli" if parts[1:] in (["cli"], ["__main__"]) else "ground"


def cycle(graph):
    """A path through the graph that comes back to its start; empty where there is none."""
    done = set()

    def walk(node, path):
        if node in path:
            return [*path[path.index(node) :], node]
        if node in done:
            return []
        for other in sorted(graph.get(node, ())):
            if found := walk(other, [*path, node]):
                return found
        done.add(node)
        return []

    return next((found for node in sorted(graph) if (found := walk(node, []))), [])


def test_every_package_has_a_layer():
    assert {part_of(name) for name in MODULES} == set(LEVELS)


def test_imports_go_down():
    up = [
        f"{name} imports {other}"
        for name, others in GRAPH.items()
        for other in sorted(others)
        if LEVELS[part_of(other)] > LEVELS[part_of(name)]
    ]
    assert up == []


def test_neither_modules_nor_packages_import_each_other():
    assert cycle(GRAPH) == []
    packages = {}
    for name, others in GRAPH.items():
        packages.setdefault(part_of(name), set()).update(part_of(other) for other in others)
    assert cycle({name: others - {name} for name, others in packages.items()}) == []


def test_a_cycle_is_found():
    assert cycle({"a": {"b"}, "b": {"c"}, "c": {"b"}}) == ["b", "c", "b"]
    assert cycle({"a": {"b", "c"}, "b": {"c"}, "c": set()}) == []


def test_planning_is_on_top():
    """Nothing in the library imports it; of the workflow, the rules alone."""
    assert [name for name, others in GRAPH.items() if part_of(name) != "planning" and any(
        part_of(other) == "planning" for other in others)] == []  # fmt: skip
    assert [path.name for path in sorted((REPOSITORY / "workflow" / "scripts").glob("*.py"))
            if any(name.startswith("visualspeech.planning") for name in imported(path))] == []  # fmt: skip


def test_torch_is_imported_by_models_alone():
    outside = [
        name
        for name, path in MODULES.items()
        if part_of(name) != "models" and any(other.split(".")[0] == "torch" for other in imported(path))
    ]
    assert outside == []


def test_families_are_named_and_not_imported():
    """What names every family must not import one, or each change of a family would re-train all others."""
    families = {
        name for name in GRAPH if name.startswith("visualspeech.models.") and "FAMILY" in MODULES[name].read_text()
    }
    assert {"visualspeech.models.stack", "visualspeech.models.hmm.family"} <= families
    for planning in ("families", "entries", "registry"):
        assert not families & GRAPH[f"visualspeech.models.{planning}"]
        assert not [name for name in families if f"visualspeech.models.{planning}" in GRAPH[name]]


@pytest.mark.parametrize("name", MODULES)
def test_a_module_can_be_read_in_one_go(name):
    lines = len(MODULES[name].read_text(encoding="utf-8").splitlines())
    assert lines < MAX_LINES, f"{MODULES[name]} has {lines} lines"


def test_nothing_that_is_read_can_run_code():
    for name, path in MODULES.items():
        tree = ast.parse(path.read_text(encoding="utf-8"))
        assert not {"pickle", "marshal", "shelve", "joblib", "dill"} & {one.split(".")[0] for one in imported(path)}, (
            name
        )
        called = {
            node.func.id for node in ast.walk(tree) if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
        }
        assert not called & {"eval", "exec"}, name
