"""Running the workflow as a user does: the command line, in a folder of its own."""

import os
import subprocess
import sys
from pathlib import Path

import yaml

from tests.paths import REPOSITORY

TINY = REPOSITORY / "config" / "test.yaml"


def overlay(folder: Path, *changes: dict, name: str = "overlay.yaml") -> tuple[Path, Path]:
    """The configuration files of the tiny run with changes laid over it, one after the other."""
    from visualspeech.settings import merged

    path = folder / name
    together: dict = {}
    for change in changes:
        together = merged(together, change)
    path.write_text(yaml.safe_dump(together))
    return TINY, path


def of_system(system: str = "fan2015", **changes) -> dict:
    """Changes of one system."""
    return {"override": {"systems": {system: changes}}}


def of_coding(coding: str = "aam51", **changes) -> dict:
    """Changes of one visual coding."""
    return {"override": {"codings": {coding: changes}}}


def tiny_corpus(**changes) -> dict:
    """The corpus of the tiny run with changes: a list is replaced as a whole."""
    corpus, *_ = yaml.safe_load(TINY.read_text())["corpora"]
    return {"corpora": [corpus | changes]}


def command(
    folder: Path, *arguments: str, cores: int = 2, configfiles: tuple = (TINY,), quiet: bool = False
) -> list[str]:
    """The command line that runs the workflow with ``folder`` as its working folder; ``quiet`` leaves its output as it
    is by default, where tests otherwise read every job and its messages."""
    overlays = ["--configfile", *map(str, configfiles)] if configfiles else []
    overlays = overlays if quiet else ["--printshellcmds", *overlays]
    return [
        sys.executable, "-m", "snakemake", "--snakefile", str(REPOSITORY / "Snakefile"), "--directory", str(folder),
        "--cores", str(cores), *arguments, *overlays,
    ]  # fmt: skip


def snakemake(
    folder: Path, *arguments: str, cores: int = 2, configfiles: tuple = (TINY,), env=None, quiet: bool = False
):
    """Run the workflow to its end; returns the completed process with everything it printed as ``.stdout``."""
    return subprocess.run(
        command(folder, *arguments, cores=cores, configfiles=configfiles, quiet=quiet),
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=900, env={**os.environ, **(env or {})},
    )  # fmt: skip


def planned_rules(folder: Path, *arguments: str, configfiles: tuple = (TINY,)) -> set[str]:
    """Names of the rules that a dry run would run."""
    done = snakemake(folder, "--dry-run", *arguments, configfiles=configfiles)
    assert done.returncode == 0, done.stdout
    lines = done.stdout.splitlines()
    return {line.split()[1].rstrip(":") for line in lines if line.startswith(("rule ", "localrule "))}


#: The table across systems for readers: it shows how fast models predict, which differs from run to run.
TIMED = {f"tables/systems.{form}" for form in ("md", "tex", "html")}


def same_in_every_run(results: Path, paths) -> dict[str, bytes]:
    """Files of a corpus's results by path, without the figures that are measured times."""
    found = {str(path.relative_to(results)): path.read_bytes() for path in paths}
    found = {name: content for name, content in found.items() if name not in TIMED}
    if (across := found.get("tables/systems.tsv")) is not None:
        lines = [line for line in across.splitlines(keepends=True) if b"\tframes_per_second\t" not in line]
        assert len(lines) < len(across.splitlines())
        found["tables/systems.tsv"] = b"".join(lines)
    return found


def tables(folder: Path, corpus: str = "tiny") -> dict[str, bytes]:
    """The final tables of a run, by path, as bytes, without measured times."""
    results = Path(folder, "results", corpus)
    return same_in_every_run(results, sorted(path for path in results.rglob("tables/*") if path.is_file()))


def files_of(folder: Path) -> set[str]:
    """Every file and folder below a folder, but those of Snakemake itself."""
    return {str(path.relative_to(folder)) for path in Path(folder).rglob("*") if ".snakemake" not in path.parts}
