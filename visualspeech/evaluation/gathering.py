"""What the report shows, gathered from the files of a run."""

from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path

import numpy as np

from visualspeech.corpora.findings import read_findings
from visualspeech.corpora.records import Utterance
from visualspeech.corpora.table import of_split
from visualspeech.evaluation import plots
from visualspeech.evaluation.report import Picture, Video
from visualspeech.evaluation.timings import read_timings
from visualspeech.face.aam.model import Aam
from visualspeech.face.aam.modes import mode_pictures
from visualspeech.face.aam.reference import Reference
from visualspeech.speech.alignment import read_alignments
from visualspeech.storage import ArrayCollection, ArrayReader, read_table

SPLITS = ("train", "validation", "test")
LIBRARIES = ("numpy", "scipy", "torch", "opencv-contrib-python-headless", "dlib-bin", "pocketsphinx", "av", "snakemake")


def learning_curves(paths: Sequence[str]) -> tuple[Picture, ...]:
    """One picture with the learning curves of all networks; a curve's folder is named by its network."""
    curves = {Path(path).parent.name: read_table(path) for path in paths}
    return (Picture(plots.learning_curves(curves), f"Learning curves of {', '.join(curves)}"),)


def trajectory_pictures(
    utterances: Sequence[Utterance], features: ArrayCollection, predictions: str, alignments: Sequence[str], count: int
) -> tuple[Picture, ...]:
    """Predicted and true appearance parameters of the first ``count`` test utterances.

    Parameters
    ----------
    predictions : path of a model's predictions, in the folder that has the model's name
    alignments : paths of alignment tables
    """
    shown = of_split(utterances, "test")[:count]
    ids = [one.id for one in shown]
    aligned = {name: found for path in alignments for name, found in read_alignments(path, ids).items()}
    pictures = []
    with ArrayReader(predictions) as predicted:
        for one in shown:
            png = plots.trajectories(
                features.array(one.id, "appearance"),
                {Path(predictions).parent.name: predicted.array(one.id, "appearance")},
                features.rate(one.id),
                [(phone.label, phone.start, phone.end) for phone in aligned[one.id].phones],
                title=f"{one.id}: {one.transcript}",
            )
            pictures.append(Picture(png, f"Appearance parameters of {one.id}, predicted and recorded"))
    return tuple(pictures)


def aam_modes(aam: Aam, reference: Reference, count: int = 4) -> tuple[Picture, ...]:
    """The first appearance, shape and texture modes, two standard deviations either way."""
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
    """Links from the report to the videos of a folder, each named by its utterance."""
    transcripts = {one.id: one.transcript for one in utterances}
    base = Path(report).parent
    return tuple(
        Video(path.relative_to(base).as_posix(), path.stem, transcripts.get(path.stem, ""), model)
        for path in sorted(Path(folder).glob("*.mp4"))
    )


def split_sizes(utterances: Sequence[Utterance], features: ArrayCollection) -> tuple[dict[str, int], dict[str, int]]:
    """Number of utterances and of frames of each split."""
    parts = {split: of_split(utterances, split) for split in SPLITS}
    frames = {split: sum(features.length(one.id, "labels") for one in part) for split, part in parts.items()}
    return {split: len(part) for split, part in parts.items()}, frames


#: Stages that go through every recorded frame; the others have no frames a second.
FRAME_STAGES = ("record_demo", "check_recordings", "align_speech", "track_landmarks", "normalise_pose",
                "sample_textures", "fit_faces", "encode_appearance", "build_features")  # fmt: skip


def stage_timings(folders: Sequence[str], frames: Mapping[str, int]):
    """What the stages cost, from their benchmark files."""
    return read_timings(folders, dict.fromkeys(FRAME_STAGES, sum(frames.values())))


def versions() -> dict[str, str]:
    """Versions of the libraries that figures may depend on."""
    return {name: version(name) for name in LIBRARIES}


def findings(path: str):
    """All that the stages found wrong or odd."""
    return tuple(read_findings(path))
