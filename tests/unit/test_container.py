"""The Dockerfile holds the README's commands; they run here, and the image is built where there is a builder."""

import fnmatch
import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from tests.paths import REPOSITORY

FILE = REPOSITORY / "Dockerfile"
INSTRUCTIONS = re.findall(r"^([A-Z]+) (.*)$", FILE.read_text().replace("\\\n", " "), re.MULTILINE)
IGNORED = [line for line in (REPOSITORY / ".dockerignore").read_text().splitlines() if not line.startswith("#")]


def given(instruction):
    return [value for name, value in INSTRUCTIONS if name == instruction]


def start_command():
    """Installation and run, as the section Start of the README has them."""
    text = (REPOSITORY / "README.md").read_text()
    return re.search(r"^## Start\n.*?^```sh\n(.*?)\n```", text, re.MULTILINE | re.DOTALL)[1]


def is_ignored(path):
    """Whether a builder leaves out a path: the last pattern that fits it or one of its folders decides."""
    places = [path, *list(path.parents)[:-1]]
    decided = False
    for pattern in IGNORED:
        wanted = pattern.removeprefix("!")
        whole = wanted.removeprefix("**/")
        names = [one.name if wanted.startswith("**/") else str(one) for one in places]
        if any(fnmatch.fnmatchcase(name, whole) for name in names):
            decided = not pattern.startswith("!")
    return decided


def tracked():
    """Files of the repository that git knows or would add."""
    listed = ["git", "-C", str(REPOSITORY), "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    try:
        done = subprocess.run(listed, capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("this is no checkout of git, or git is not installed")
    files = sorted({REPOSITORY / name for name in done.stdout.split("\0") if name})
    return [path.relative_to(REPOSITORY) for path in files if path.is_file()]


@pytest.fixture
def context(tmp_path):
    """What `COPY . .` brings into the image."""
    for path in tracked():
        if not is_ignored(path):
            target = tmp_path / "visualspeech" / path
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(REPOSITORY / path, target)
    return tmp_path / "visualspeech"


def test_the_commands_are_those_of_the_readme():
    *_, install = given("RUN")
    assert f"{install} && {' '.join(json.loads(given('CMD')[0]))}" == start_command()


def test_nothing_but_python_is_installed_from_debian():
    system, _ = given("RUN")
    assert re.search(r"--no-install-recommends (.*?) &&", system)[1].split() == ["python3", "python3-venv"]
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text())["project"]
    assert project["requires-python"] == ">=3.11"  # that of Debian 12
    assert "bookworm" in given("FROM")[0]


def test_what_git_ignores_stays_outside():
    known = {line.rstrip("/") for line in (REPOSITORY / ".gitignore").read_text().splitlines()}
    assert known - {one.removeprefix("**/") for one in IGNORED} == set()
    assert is_ignored(Path(".git/config")) and is_ignored(Path("results/demo/x.h5"))
    assert not any(is_ignored(path) for path in tracked())


def test_the_commands_run_on_what_the_image_holds(context):
    """Installation without the dependencies, and a dry run with those of this environment."""
    *_, install = given("RUN")
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    installed = subprocess.run(
        ["bash", "-euc", install.replace("python3 ", f"{sys.executable} ", 1)],
        cwd=context, env=environment | {"PIP_NO_DEPS": "1"}, capture_output=True, text=True,
    )  # fmt: skip
    if "No matching distribution found for setuptools" in installed.stderr:
        pytest.skip("pip reaches no package index here")
    assert installed.returncode == 0, installed.stdout + installed.stderr
    where = [".venv/bin/python", "-c", "import visualspeech; print(visualspeech.__file__)"]
    shown = subprocess.run(where, cwd=context, env=environment, capture_output=True, text=True)
    assert shown.stdout.strip() == str(context / "visualspeech" / "__init__.py"), shown.stderr
    program, *arguments = json.loads(given("CMD")[0])
    assert program == ".venv/bin/snakemake"
    planned = subprocess.run(
        [sys.executable, "-m", "snakemake", *arguments, "--dry-run"],
        cwd=context, env=environment | {"PYTHONPATH": os.pathsep.join([str(context), *sys.path])},
        capture_output=True, text=True,
    )  # fmt: skip
    assert planned.returncode == 0, planned.stdout + planned.stderr
    assert "results/demo/report.html" in planned.stdout


def builder():
    """A program that can build the image here."""
    for name in ("podman", "docker"):
        if shutil.which(name) and subprocess.run([name, "info"], capture_output=True).returncode == 0:
            return name
    return None


def test_the_image_builds_and_plans_the_default_run():
    program = builder()
    if program is None:
        pytest.skip("neither podman nor a running docker is here to build the image")
    if subprocess.run([program, "pull", given("FROM")[0]], capture_output=True).returncode:
        pytest.skip(f"{program} cannot fetch {given('FROM')[0]}")
    built = subprocess.run(
        [program, "build", "-t", "visualspeech-test", str(REPOSITORY)], capture_output=True, text=True
    )
    assert built.returncode == 0, built.stderr[-4000:]
    planned = subprocess.run(
        [program, "run", "--rm", "visualspeech-test", *json.loads(given("CMD")[0]), "--dry-run"],
        capture_output=True, text=True,
    )  # fmt: skip
    assert planned.returncode == 0 and "results/demo/report.html" in planned.stdout, planned.stderr[-4000:]
