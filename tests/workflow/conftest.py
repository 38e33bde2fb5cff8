"""One complete run of the smallest configuration, shared by the tests that look at it."""

from pathlib import Path

import pytest

from tests.workflow.running import snakemake


@pytest.hookimpl(tryfirst=True)  # before the workers read the mark
def pytest_collection_modifyitems(items):
    """Keep the tests of this folder on one worker: they share a finished run."""
    for item in items:
        if Path(__file__).parent in item.path.parents:
            item.add_marker(pytest.mark.xdist_group("workflow"))


@pytest.fixture(scope="session")
def tiny_run(tmp_path_factory):
    """Working folder of a finished ``all`` on the tiny corpus; tests leave it as it is (or restore it)."""
    folder = tmp_path_factory.mktemp("tiny")
    done = snakemake(folder, "all")
    assert done.returncode == 0, done.stdout[-6000:]
    return folder
