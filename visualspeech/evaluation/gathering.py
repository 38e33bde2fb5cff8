"""Gathers the content of the report from the files of a run."""

from collections.abc import Mapping, Sequence
from datetime import date
from importlib.metadata import version
from pathlib import Path

import numpy as np

from visualspeech import __version__
from visualspeech.corpora.records import Utterance
from visualspeech.corpora.split import SPLITS
from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.evaluation import plots
from visualspeech.evaluation.forms import fragment_of
from visualspeech.evaluation.report import Picture, SystemSection, Video
from visualspeech.evaluation.timings import StageTiming, read_timings
from visualspeech.face.aam.model import Aam
from visualspeech.face.aam.modes import mode_pictures
from visualspeech.face.aam.reference import Reference
from visualspeech.models.rows import ModelRow
from visualspeech.provenance import command, commit
from visualspeech.speech.alignment import alignments_of
from visualspeech.storage.arrays import ArrayCollection, ArrayReader
from visualspeech.storage.files import read_text
from visualspeech.storage.tables import read_table

LIBRARIES = ("numpy", "scipy", "torch", "opencv-contrib-python-headless", "dlib-bin", "pocketsphinx", "av", "snakemake")

#: Maximum number of networks in one panel of learning curves; more are drawn in one panel per topology.
MAX_CURVES = 6

VISEMES = (
    "The most frequent classes of dynamic visemes, with their share of the training gestures: the face when the mean "
    "gesture begins, in its middle, and at its end"
)
#: Stages that process every recorded frame once; other stages have no frames per second.
FRAME_STAGES = ("check_recordings", "track_landmarks", "normalise_pose", "read_motion")


def fragments(paths: Sequence[str]) -> tuple[str, ...]:
    """The tables of pages written by :func:`visualspeech.evaluation.forms.to_html_page`."""
    return tuple(fragment_of(read_text(path)) for path in paths)


def system_section(given: Mapping, alignments: Sequence[str], report: str, trajectories: int = 3) -> SystemSection:
    """The section of one system in the report.

    Parameters
    ----------
    given : ``name`` and ``title`` of the system; ``facts`` as (name, text) pairs; and paths: ``utterances`` (the table
        of those that its models see), ``tables`` (HTML pages), ``targets`` (shards), ``curves`` (of the ``rows``, plain
        :class:`ModelRow`, in the same order), ``coding`` and ``reference`` (models, empty for a coding without
        texture), ``visemes`` (pictures), ``predictions`` of the model named ``model``, ``videos`` (a folder), and
        ``figures`` (pictures) with their ``captions``. What is empty is left out of the section
    alignments : shards of the alignment
    report : path of the page, to which links are relative
    trajectories : number of test utterances whose trajectories are shown
    """
    rows, utterances = list(map(ModelRow.of, given["rows"])), read_utterances(given["utterances"])
    with ArrayCollection(given["targets"]) as targets:
        return SystemSection(
            name=given["name"],
            title=given["title"],
            facts=(*map(tuple, given["facts"]), ("frames", frames_text(utterances, targets))),
            tables=fragments(given["tables"]),
            learning_curves=learning_curves(rows, [read_table(path) for path in given["curves"]]),
            trajectories=trajectory_pictures(
                of_split(utterances, "test")[:trajectories], targets, given["predictions"], given["model"], alignments
            )
            if given["predictions"]
            else (),
            modes=aam_modes(Aam.load(given["coding"]), Reference.load(given["reference"])) if given["coding"] else (),
            figures=tuple(
                Picture(Path(path).read_bytes(), caption)
                for path, caption in zip(given["figures"], given["captions"], strict=True)
            ),
            visemes=tuple(Picture(Path(path).read_bytes(), VISEMES) for path in given["visemes"]),
            videos=videos(given["videos"], report, utterances, given["model"]) if given["videos"] else (),
        )


def learning_curves(rows: Sequence[ModelRow], curves: Sequence) -> tuple[Picture, ...]:
    """One figure with the learning curves of all networks; none without networks."""
    if not rows:
        return ()
    panels: dict[str, dict[str, object]] = {}
    for row, curve in zip(rows, curves, strict=True):
        panel = str(row.settings.get("letters", row.group)) if len(rows) > MAX_CURVES else ""
        panels.setdefault(panel, {})[row.name] = curve
    caption = f"Learning curves of {', '.join(row.name for row in rows)}"
    return (Picture(plots.learning_curves(panels), caption),)


def trajectory_pictures(
    utterances: Sequence[Utterance], targets: ArrayCollection, predictions: str, model: str, alignments: Sequence[str]
) -> tuple[Picture, ...]:
    """Figures of the predicted and true appearance parameters, one per utterance."""
    aligned = alignments_of(alignments, [one.id for one in utterances])
    pictures = []
    with ArrayReader(predictions) as predicted:
        for one in utterances:
            png = plots.trajectories(
                targets.array(one.id, "appearance"),
                {model: predicted.array(one.id, "appearance")},
                targets.rate(one.id),
                [(phone.label, phone.start, phone.end) for phone in aligned[one.id].phones],
                title=f"{one.id}: {one.transcript}",
            )
            pictures.append(Picture(png, f"Parameters of the visual coding of {one.id}, predicted and recorded"))
    return tuple(pictures)


def aam_modes(aam: Aam, reference: Reference, count: int = 4) -> tuple[Picture, ...]:
    """Figures of the first appearance, shape and texture modes at -2, 0 and 2 standard deviations."""
    pictures = []
    letters = {"appearance": "v", "shape": "a", "texture": "b"}
    for (kind, letter), size in zip(letters.items(), (aam.sizes[2], *aam.sizes[:2]), strict=True):
        number = min(count, size)
        grid = [mode_pictures(aam, reference, kind, mode) for mode in range(number)]
        height = max(picture.shape[0] for row in grid for picture in row)
        padded = [[_to_height(picture, height) for picture in row] for row in grid]
        names = [f"{letter}{mode + 1}" for mode in range(number)]
        png = plots.mode_pictures(np.array(padded), names, ["−2 σ", "mean", "+2 σ"])
        pictures.append(Picture(png, f"{kind.capitalize()} modes of the appearance model"))
    return tuple(pictures)


def _to_height(picture: np.ndarray, height: int) -> np.ndarray:
    return np.pad(picture, ((0, height - picture.shape[0]), (0, 0), (0, 0)), constant_values=255)


def videos(folder: str, report: str, utterances: Sequence[Utterance], model: str) -> tuple[Video, ...]:
    """Links to the videos in a folder."""
    transcripts = {one.id: one.transcript for one in utterances}
    base = Path(report).parent
    return tuple(
        Video(path.relative_to(base).as_posix(), path.stem, transcripts.get(path.stem, ""), model)
        for path in sorted(Path(folder).glob("*.mp4"))
    )


def split_sizes(utterances: Sequence[Utterance]) -> dict[str, int]:
    """Number of utterances of each split."""
    return {split: len(of_split(utterances, split)) for split in SPLITS}


def frames_text(utterances: Sequence[Utterance], targets: ArrayCollection) -> str:
    """Number of frames of each split at the rate of a system, as text."""
    counts = {
        split: sum(targets.length(one.id, "appearance") for one in of_split(utterances, split)) for split in SPLITS
    }
    return f"{counts['train']} training, {counts['validation']} validation, {counts['test']} test"


def stage_timings(benchmarks: Sequence[str], faces: Sequence[str]) -> tuple[StageTiming, ...]:
    """Cost of the stages from their benchmark files; recorded frames are counted in the files of the faces."""
    with ArrayCollection(faces) as recorded:
        frames = sum(recorded.length(one, "points") for one in recorded.ids)
    return read_timings(benchmarks, dict.fromkeys(FRAME_STAGES, frames))


def origin() -> dict[str, str]:
    """Commit, date and command of a run, as :class:`ReportContent` takes them.

    They are determined when the report is written; as parameters of its job they would make it outdated at every call.
    """
    return {"commit": commit(), "command": command(), "date": date.today().isoformat()}


def versions() -> dict[str, str]:
    """Versions of this program and of the libraries on which figures may depend."""
    return {"visualspeech": __version__} | {name: version(name) for name in LIBRARIES}
