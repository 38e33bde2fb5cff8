"""One complete run of the smallest configuration, shared by the tests that look at it.

Every module here carries the same group mark, so that parallel test workers make that run once.
"""

import pytest

from tests.workflow.running import snakemake


@pytest.fixture(scope="session")
def tiny_run(tmp_path_factory):
    """Working folder of a finished ``all`` on the tiny corpus; tests leave it as it is (or restore it)."""
    folder = tmp_path_factory.mktemp("tiny")
    done = snakemake(folder, "all")
    assert done.returncode == 0, done.stdout[-6000:]
    return folder
