"""Gathers the content of the report from the files of a run."""

import io
from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import date
from importlib.metadata import version
from pathlib import Path

import numpy as np

from visualspeech import __version__
from visualspeech.corpora.records import Utterance
from visualspeech.corpora.split import SPLITS
from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.errors import DamagedFile
from visualspeech.evaluation import plots
from visualspeech.evaluation.comparison_matrix import comparison_matrix
from visualspeech.evaluation.comparisons import ComparisonSettings
from visualspeech.evaluation.conclusions import conclude
from visualspeech.evaluation.forms import fragment_of, to_html
from visualspeech.evaluation.lip_rows import read_lip_tables
from visualspeech.evaluation.measured import MeasuredRows, cells_of
from visualspeech.evaluation.overview import SystemOverview, bands, figures_of, short_table
from visualspeech.evaluation.report import FileLink, Picture, ShownTable, SystemSection, UtteranceFiles
from visualspeech.evaluation.report_videos import videos
from visualspeech.evaluation.statistics import BootstrapSettings
from visualspeech.evaluation.timings import StageTiming, read_timings
from visualspeech.face.aam.model import Aam
from visualspeech.face.aam.modes import mode_pictures
from visualspeech.face.aam.reference import Reference
from visualspeech.models.rows import ModelRow
from visualspeech.provenance import command, commit
from visualspeech.speech.alignment import alignments_of
from visualspeech.storage.arrays import ArrayCollection, ArrayReader
from visualspeech.storage.files import read_text
from visualspeech.storage.tables import read_numbers, read_table

LIBRARIES = ("numpy", "scipy", "torch", "opencv-contrib-python-headless", "dlib-bin", "pocketsphinx", "av", "snakemake")

#: Maximum number of networks in one panel of learning curves; more are drawn in one panel per topology.
MAX_CURVES = 6

VISEMES = (
    "The most frequent classes of dynamic visemes, with their share of the training gestures: the face when the mean "
    "gesture begins, in its middle, and at its end"
)
#: Stages that process every recorded frame once; other stages have no frames per second.
FRAME_STAGES = ("check_recordings", "track_landmarks", "normalise_pose", "read_motion")


#: What files are called that stand in the report as links, by their suffix.
FORM_TITLES = {".tsv": "TSV", ".tex": "TeX", ".md": "Markdown"}


def shown_tables(paths: Sequence[Sequence[str]], report: str) -> tuple[ShownTable, ...]:
    """Tables with links to their files.

    Parameters
    ----------
    paths : of each table its files, one of them a page of :func:`visualspeech.evaluation.forms.to_html_page`
    report : path of the page, to which links are relative
    """
    return tuple(
        ShownTable(fragment_of(read_text(path)), file_links(files, report))
        for files in paths
        for path in files
        if path.endswith(".html")
    )


def file_links(files: Sequence[str], report: str) -> tuple[FileLink, ...]:
    """Links to the forms of a table; of several files of one form each with its name."""
    suffixes = [Path(path).suffix for path in files]
    return tuple(
        FileLink(
            FORM_TITLES[suffix] if suffixes.count(suffix) == 1 else f"{FORM_TITLES[suffix]} ({Path(path).stem})",
            _relative(path, report),
        )
        for path, suffix in zip(files, suffixes, strict=True)
        if suffix in FORM_TITLES
    )


def _relative(path: str | Path, report: str) -> str:
    return Path(path).relative_to(Path(report).parent).as_posix()


def overviews(systems: Sequence[Mapping]) -> tuple[SystemOverview, ...]:
    """What the overview shows of each system, on the test utterances that all of them have.

    Parameters
    ----------
    systems : as of :func:`system_section`, with ``validation`` (name of a model -> path of its statistics), ``lips``
        and ``costs`` (paths), and ``comparison`` and ``bootstrap`` (settings)
    """
    tested = [{one.id for one in of_split(read_utterances(given["utterances"]), "test")} for given in systems]
    common, found = set.intersection(*tested) if tested else set(), []
    for given in systems:
        rows, names = list(map(ModelRow.of, given["rows"])), [row["name"] for row in given["rows"]]
        lips = MeasuredRows.of(given["rows"], read_lip_tables(given["lips"], given["costs"], names)).on(common)
        validation = {name: read_numbers(path) for name, path in given["validation"].items()}
        settings = ComparisonSettings(**given["comparison"]), BootstrapSettings(**given["bootstrap"])
        spoken = next((row.cell or row.name for row in rows if row.name == given["model"]), "")
        conclusion = conclude(rows, validation, lips, *settings)
        found.append(SystemOverview(given["name"], given["title"], pooled_rows(rows), conclusion, spoken))
    return tuple(found)


def pooled_rows(rows: Sequence[ModelRow]) -> dict[str, ModelRow]:
    """Name of a cell -> its first row, as :meth:`MeasuredRows.pooled` names them."""
    return {cell: replace(of_cell[0], name=cell) for cell, of_cell in cells_of(rows).items()}


def overview(systems: Sequence[SystemOverview], across: str, digits: int = 3) -> dict:
    """The figure of all systems and the short table, as :class:`ReportContent` takes them.

    Parameters
    ----------
    across : path of the TSV of the table across systems
    """
    figures = figures_of(read_made_table(across, ("system", "row", "metric", "part")))
    short = short_table(systems, figures, digits)
    return {"bands": bands(systems, figures), "short": to_html([short]) if short else ""}


def read_made_table(path: str, text_columns: Sequence[str]):
    """A table with lines of facts above it (:func:`visualspeech.evaluation.forms.all_forms`) as a data frame."""
    import pandas

    lines = read_text(path).splitlines(keepends=True)
    first = next((number for number, line in enumerate(lines) if not line.startswith("# ")), len(lines))
    types = dict.fromkeys(text_columns, str)
    missing = {name: [""] for name in lines[first].rstrip("\n").split("\t")} if lines[first:] else {}
    missing = {name: cells for name, cells in missing.items() if name not in types}
    try:
        return pandas.read_csv(
            io.StringIO("".join(lines[first:])), sep="\t", dtype=types, keep_default_na=False, na_values=missing
        )
    except ValueError as error:
        raise DamagedFile(path, "it is no table of a run") from error


def system_section(
    given: Mapping, conclusion: str, alignments: Sequence[str], report: str, trajectories: int = 3
) -> SystemSection:
    """The section of one system in the report.

    Parameters
    ----------
    given : ``name`` and ``title`` of the system; ``facts`` as (name, text) pairs; ``rows`` (plain :class:`ModelRow`);
        and paths: ``utterances`` (the table of those that its models see), ``tables`` (of each table all its files),
        ``comparisons`` (the same of one table), ``targets`` (shards), ``curves`` (name of a row -> path), ``coding``
        and ``reference`` (models, empty for a coding without texture), ``visemes`` (pictures), ``predictions`` of the
        model named ``model``, ``videos`` (a folder), and ``figures`` (pictures) with their ``captions``. What is empty
        is left out of the section
    conclusion : the sentence on its best model
    alignments : shards of the alignment
    report : path of the page, to which links are relative
    trajectories : number of test utterances whose trajectories are shown
    """
    rows, utterances = list(map(ModelRow.of, given["rows"])), read_utterances(given["utterances"])
    titles = {row.name: row.title for row in rows}
    with ArrayCollection(given["targets"]) as targets:
        return SystemSection(
            name=given["name"],
            title=given["title"],
            conclusion=conclusion,
            facts=(*map(tuple, given["facts"]), ("frames", frames_text(utterances, targets))),
            tables=shown_tables(given["tables"], report),
            comparisons=comparisons(given, rows, report),
            learning_curves=learning_curves(
                [row for row in rows if row.name in given["curves"]], list(map(read_table, given["curves"].values()))
            ),
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
            videos=videos(
                given["videos"], report, utterances, titles.get(given["model"], given["model"]), given["title"]
            )
            if given["videos"]
            else (),
        )


def comparisons(given: Mapping, rows: Sequence[ModelRow], report: str) -> tuple[ShownTable, ...]:
    """All paired comparisons of a system as one table, with links to its files; none without them."""
    for path in given["comparisons"]:
        if path.endswith(".tsv"):
            frame = read_made_table(path, ("metric", "first", "second", "better"))
            table = comparison_matrix(frame, pooled_rows(rows), given["comparison"]["level"])
            return (ShownTable(to_html([table]), file_links(given["comparisons"], report)),)
    return ()


def learning_curves(rows: Sequence[ModelRow], curves: Sequence) -> tuple[Picture, ...]:
    """One figure with the learning curves of all networks; none without networks."""
    if not rows:
        return ()
    panels: dict[str, dict[str, object]] = {}
    for row, curve in zip(rows, curves, strict=True):
        panel = str(row.settings.get("letters", row.group)) if len(rows) > MAX_CURVES else ""
        panels.setdefault(panel, {})[row.name] = curve
    names = ", ".join(row.name for row in rows)
    caption = f"Learning curves of {names if len(rows) <= MAX_CURVES else f'{len(rows)} networks'}"
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


def test_utterances(
    utterances: Sequence[Utterance], folder: str, systems: Sequence[SystemSection], report: str
) -> tuple[UtteranceFiles, ...]:
    """The test utterances with links to their alignment, their recording and their videos.

    Parameters
    ----------
    folder : of TextGrid files with their sound
    systems : whose videos are linked
    report : path of the page; a recording that does not lie below its folder has no link
    """
    found, base = [], Path(report).parent
    shown = {(system.title, one.utterance): one.path for system in systems for one in system.videos}
    for one in of_split(utterances, "test"):
        files = [(f"{folder}/{one.id}.TextGrid", "TextGrid"), (f"{folder}/{one.id}.wav", "sound")]
        if Path(one.file).is_relative_to(base):
            files.append((one.file, "recording"))
        links = [FileLink(label, _relative(path, report)) for path, label in files if Path(path).is_file()]
        links += [FileLink(title, path) for (title, name), path in shown.items() if name == one.id]
        found.append(UtteranceFiles(one.id, one.transcript, tuple(links)))
    return tuple(found)


def folder_links(folders: Sequence[str], report: str) -> tuple[FileLink, ...]:
    """Links to folders, each with its own name."""
    return tuple(FileLink(Path(path).name, f"{_relative(path, report)}/") for path in folders)


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
