"""Where real recordings are, for the tests that need them."""

import os
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[1]


def grid_root() -> Path | None:
    """Root of a copy of GRID: ``GRID_ROOT``, or the folder beside the repository; None where there is none."""
    candidates = [os.environ.get("GRID_ROOT", ""), REPOSITORY.parent / "shared" / "corpora" / "grid"]
    return next((Path(path) for path in candidates if path and Path(path).is_dir()), None)
