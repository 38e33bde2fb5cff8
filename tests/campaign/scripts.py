"""A workflow script, run in this process as a job would run it."""

import contextlib
import io
import runpy
from collections.abc import Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import NamedTuple

from tests.paths import REPOSITORY


class Files(SimpleNamespace):
    """Named files or params of a job, which can also be asked for by number."""

    def __getitem__(self, key):
        return list(vars(self).values())[key] if isinstance(key, int) else vars(self)[key]


class Done(NamedTuple):
    """Exit status of a script, and what it said on standard error."""

    status: int
    said: str


def run_script(name: str, folder: Path, source: Mapping, output: Mapping, params: Mapping | None = None) -> Done:
    """Run ``workflow/scripts/<name>.py`` on files of ``folder``."""
    job = SimpleNamespace(
        input=Files(**source),
        output=Files(**output),
        params=Files(**(params or {})),
        log=[str(folder / "logs" / f"{name}.log")],
        resources=SimpleNamespace(tmpdir=str(folder)),
        wildcards=SimpleNamespace(),
    )
    said = io.StringIO()
    status = 0
    with contextlib.redirect_stderr(said):
        try:
            runpy.run_path(str(REPOSITORY / "workflow" / "scripts" / f"{name}.py"), {"snakemake": job})
        except SystemExit as left:
            status = int(left.code or 0)
    return Done(status, said.getvalue())
