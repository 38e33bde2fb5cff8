"""Runs on a Slurm cluster: what ``profiles/slurm`` asks before anything is planned."""

import subprocess
from importlib.util import find_spec

PLUGIN = "snakemake_executor_plugin_slurm"


def check_plugin() -> None:
    """End the program with one sentence if Snakemake's executor for Slurm is not installed."""
    if find_spec(PLUGIN) is None:
        raise SystemExit(
            "profiles/slurm needs Snakemake's executor for Slurm; install it with: "
            "pip install -c constraints.txt -e '.[cluster]' (docs/cluster.md)."
        )


def status_command() -> str:
    """The command that tells the state of jobs: ``sacct`` where the cluster keeps accounts, ``squeue`` otherwise.

    Without accounts the executor would wait for ever for what ``sacct`` says.
    """
    try:
        done = subprocess.run(["sacct", "--noheader", "--starttime", "now"], capture_output=True, timeout=60)
    except (OSError, subprocess.TimeoutExpired):
        return "squeue"
    return "sacct" if done.returncode == 0 else "squeue"
