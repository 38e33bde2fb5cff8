"""Running the workflow as a user does: the command line, in a folder of its own."""

import os
import subprocess
import sys
from pathlib import Path

from tests.paths import REPOSITORY

TINY = REPOSITORY / "config" / "test.yaml"


def command(folder: Path, *arguments: str, cores: int = 2, configfiles: tuple = (TINY,)) -> list[str]:
    """The command line that runs the workflow with ``folder`` as its working folder."""
    overlays = ["--configfile", *map(str, configfiles)] if configfiles else []
    return [
        sys.executable, "-m", "snakemake", "--snakefile", str(REPOSITORY / "Snakefile"), "--directory", str(folder),
        "--cores", str(cores), *arguments, *overlays,
    ]  # fmt: skip


def snakemake(folder: Path, *arguments: str, cores: int = 2, configfiles: tuple = (TINY,), env=None):
    """Run the workflow to its end; returns the completed process with everything it printed as ``.stdout``."""
    return subprocess.run(
        command(folder, *arguments, cores=cores, configfiles=configfiles),
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=900, env={**os.environ, **(env or {})},
    )  # fmt: skip


def planned_rules(folder: Path, *arguments: str, configfiles: tuple = (TINY,)) -> set[str]:
    """Names of the rules that a dry run would run."""
    done = snakemake(folder, "--dry-run", *arguments, configfiles=configfiles)
    assert done.returncode == 0, done.stdout
    lines = done.stdout.splitlines()
    return {line.split()[1].rstrip(":") for line in lines if line.startswith(("rule ", "localrule "))}


def tables(folder: Path, corpus: str = "tiny") -> dict[str, bytes]:
    """The final tables of a run, by name, as bytes."""
    found = sorted(Path(folder, "results", corpus, "fan2015", "tables").iterdir())
    return {path.name: path.read_bytes() for path in found}
