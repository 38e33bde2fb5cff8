"""The public names: what they are, what they cost, and that no job's digest reaches them."""

import ast
import json
import subprocess
import sys

import pytest

import visualspeech
from tests.paths import REPOSITORY
from visualspeech import provenance
from visualspeech.api import PUBLIC

SCRIPTS = sorted((REPOSITORY / "workflow" / "scripts").glob("*.py"))


def test_every_public_name_is_what_its_module_defines():
    for name, module in PUBLIC.items():
        found = getattr(visualspeech, name)
        assert found.__name__ == name and found.__module__ == module, name
        assert found.__doc__


def test_the_names_are_listed():
    assert visualspeech.__all__ == sorted(PUBLIC)
    assert {*PUBLIC, "__version__"} <= set(dir(visualspeech))
    names: dict = {}
    exec("from visualspeech import *", names)  # noqa: S102
    assert set(PUBLIC) <= set(names)


def test_an_unknown_name_is_an_attribute_error_and_modules_are_found():
    with pytest.raises(AttributeError, match="module 'visualspeech' has no attribute 'aline'"):
        _ = visualspeech.aline
    with pytest.raises(ImportError, match="cannot import name 'aline'"):
        exec("from visualspeech import aline")  # noqa: S102
    assert not hasattr(visualspeech, "__wrapped__")
    from visualspeech import models

    assert models.__name__ == "visualspeech.models"


def test_type_checkers_see_the_same_names():
    tree = ast.parse((REPOSITORY / "visualspeech" / "__init__.pyi").read_text())
    found = {
        alias.asname: (node.module, alias.name)
        for node in tree.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    assert found == {name: (module, name) for name, module in PUBLIC.items()}
    assert (REPOSITORY / "visualspeech" / "py.typed").is_file()


@pytest.mark.parametrize(
    ("statement", "absent"),
    [
        ("import visualspeech; dir(visualspeech)", ("numpy", "pandas", "torch", "visualspeech.errors")),
        ("from visualspeech import align, track, fit_aam, score, Run, SettingError", ("torch", "av", "dlib")),
        ("from visualspeech import Speaker, train, predict, load_model, export_run", ("torch", "dlib")),
    ],
)
def test_importing_a_name_loads_little(statement, absent):
    code = f"import sys, json; {statement}; print(json.dumps([name for name in {absent} if name in sys.modules]))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert json.loads(done.stdout) == []


def reached(script):
    """The modules of the library that a script's digest covers."""
    found, waiting = set(), [script]
    while waiting:
        path = waiting.pop()
        if path not in found:
            found.add(path)
            waiting.extend(provenance._read(path).imports)
    return {path.relative_to(provenance.PACKAGE).as_posix() for path in found if provenance.PACKAGE in path.parents}


def test_no_job_reaches_the_public_names():
    """The file of the package is in every digest; it adds no module and no data file to any."""
    own = provenance._read(provenance.PACKAGE / "__init__.py")
    assert own.imports == own.data == ()
    for script in SCRIPTS:
        found = reached(script)
        assert "__init__.py" in found, script
        assert not {path for path in found if path.startswith(("api/", "cli.py"))}, script
