"""The command ``visualspeech export``."""

import argparse
from pathlib import Path

# The library is imported only when the command runs, so that help and errors appear at once.


def add_export(commands) -> None:
    """Add the command to the subparsers of the console command."""
    parser = commands.add_parser(
        "export",
        help="write trajectories, truth and labels of a run as CSV or NumPy files",
        description="Write the recorded and predicted parameters and the labels of each utterance of a finished run "
        "into a new folder, for other programs.",
    )
    parser.add_argument("folder", type=Path, metavar="RUN", help="results of a corpus, for example results/demo")
    form = parser.add_mutually_exclusive_group(required=True)
    form.add_argument("--csv", dest="form", action="store_const", const="csv", help="one table per trajectory")
    form.add_argument("--npz", dest="form", action="store_const", const="npz", help="one NumPy file per utterance")
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FOLDER", help="the new folder (default: the corpus, then _csv or _npz)"
    )
    several = {"action": "append", "default": [], "metavar": "NAME"}
    parser.add_argument("--system", **several, help="system; may be repeated (default: all)")
    parser.add_argument(
        "--model", **several, help="model whose predictions are exported; may be repeated (default: all)"
    )
    parser.add_argument("--split", **several, help="train, validation or test; may be repeated (default: all)")
    parser.add_argument("--utterance", **several, help="id of an utterance; may be repeated (default: all)")
    parser.add_argument("--points", action="store_true", help="also the points of the face")
    parser.add_argument("--quiet", action="store_true", help="no progress lines")
    parser.add_argument("--debug", action="store_true", help=argparse.SUPPRESS)
    parser.set_defaults(run=_export)


def _export(given: argparse.Namespace) -> None:
    from visualspeech.api.exporting import export_run
    from visualspeech.api.runs import Run

    with Run(given.folder) as run:
        export_run(
            run,
            given.output or Path(f"{run.corpus}_{given.form}"),
            given.form,
            systems=given.system,
            models=given.model,
            splits=given.split,
            utterances=given.utterance,
            points=given.points,
        )
