"""One version of everything, wherever it is named."""

import re
import tomllib

from tests.paths import REPOSITORY


def pins():
    lines = (REPOSITORY / "constraints.txt").read_text().splitlines()
    return dict(line.split("==") for line in lines if not line.startswith("#"))


def normal(name):
    return re.sub(r"[-_.]+", "-", name).lower()


def test_every_dependency_is_pinned_exactly():
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text())["project"]
    wanted = project["dependencies"] + sum(project["optional-dependencies"].values(), [])
    assert {normal(name) for name in wanted} <= set(pins())
    assert pins()["torch"] == "2.13.0"
