"""Settings that Snakemake's own reader takes, through the command line: refused in a sentence, nothing written."""

import pytest

from tests.workflow.running import TINY, files_of, snakemake

pytestmark = pytest.mark.xdist_group("workflow")


@pytest.mark.parametrize(
    ("overlay", "arguments", "said"),
    [
        ("split: {train: 0.8, test: 0.1, train: 0.7}\n", (), "the key `train` is given twice, in line 1 and in line 1"),
        ("seed: 1\n", ("--config", "seed=" + "9" * 24), "must be at least 0 and at most 999999999"),
        ("seed: 1\n", ("--config", "results=a{b}"), "without line breaks, braces"),
    ],
)
def test_mistakes_that_snakemake_passes_over(tmp_path, overlay, arguments, said):
    path = tmp_path / "mine.yaml"
    path.write_text(overlay)
    done = snakemake(tmp_path, "--dry-run", *arguments, configfiles=(TINY, path))
    assert done.returncode != 0 and said in done.stdout and "Traceback" not in done.stdout
    assert files_of(tmp_path) == {"mine.yaml"}
