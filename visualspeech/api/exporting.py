"""Export of a finished run: trajectories, truth and labels of each utterance as CSV or NumPy files."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from visualspeech.api.runs import Run
from visualspeech.api.systems import SPLITS, System
from visualspeech.corpora.records import LEGAL_ID, MAX_ID
from visualspeech.errors import DamagedFile, SettingError, StorageError
from visualspeech.fields import shortened
from visualspeech.jobs import log, progress
from visualspeech.speech.alignment import TIERS
from visualspeech.storage.files import check_writable, replacing, write_text

FORMS = ("csv", "npz")
#: Columns of the list of utterances.
COLUMNS = ("id", "speaker", "split", "emotion", "transcript")


@dataclass(frozen=True)
class Exported:
    """What is exported of one utterance.

    Parameters
    ----------
    rate : frame rate in Hz
    times : (T,) seconds
    labels : word, phone and state -> (T,) text
    segments : tier, label, start and end (seconds) of each segment of the alignment
    parameters : "truth" or name of a model -> (T, N)
    points : the same -> (T, P, d); empty unless asked for
    """

    rate: float
    times: np.ndarray
    labels: dict[str, np.ndarray]
    segments: dict[str, np.ndarray]
    parameters: dict[str, np.ndarray]
    points: dict[str, np.ndarray]


def export_run(
    run: str | Path | Run,
    output: str | Path,
    form: str = "csv",
    *,
    systems: Sequence[str] = (),
    models: Sequence[str] = (),
    splits: Sequence[str] = (),
    utterances: Sequence[str] = (),
    points: bool = False,
) -> Path:
    """Write parameters, predictions and labels of a run into a new folder, whose ``README.txt`` describes it.

    Parameters
    ----------
    run : results folder of a corpus
    output : folder to write; it must not exist, or be empty
    form : ``csv``, one table per utterance and trajectory, or ``npz``, one NumPy file per utterance; no file needs
        ``allow_pickle``
    systems, models, splits, utterances : which ones; empty: all, or with ``models`` the systems that have one of them
    points : whether the points of the face are exported too, decoded from the parameters

    Returns
    -------
    the folder

    Raises
    ------
    SettingError
        A name is unknown, nothing would be exported, or the folder holds something.
    StorageError
        ``run`` is no results folder, the run is not finished, or the folder cannot be written.
    """
    if not isinstance(run, Run):
        with Run(run) as opened:
            return export_run(
                opened, output, form, systems=systems, models=models, splits=splits, utterances=utterances,
                points=points,
            )  # fmt: skip
    output = Path(output)
    if form not in FORMS:
        raise SettingError(f"there is no form {form!r}; give one of {', '.join(FORMS)}.")
    chosen = _chosen(run, systems, models, splits, utterances)
    _check_output(run, output)
    with replacing(output) as folder:
        folder.mkdir()
        for system, names, of_models in chosen:
            own = folder / system.name
            own.mkdir()
            write = _write_csv if form == "csv" else _write_npz
            rows = []
            for name in progress(names, len(names), f"utterances of {system.name}"):
                exported = _exported(system, name, of_models, points)
                write(own, name, exported)
                rows.append((*_about(system, name), exported.rate, len(exported.times)))
            _write(own / "utterances.csv", [*COLUMNS, "rate_hz", "frames"], zip(*rows, strict=True))
        write_text(folder / "README.txt", _description(run, chosen, form, points))
    log.info("%s: %s", output, ", ".join(f"{len(names)} utterances of {one.name}" for one, names, _ in chosen))
    return output


def _chosen(run: Run, systems, models, splits, utterances) -> list[tuple[System, list[str], list[str]]]:
    """The systems, and the utterances and models of each, that are exported."""
    if not run.systems:
        raise StorageError(f"the run in {run.folder} has no system yet. Run its target `all` to its end.")
    _check("system", systems, list(run.systems))
    _check("split", splits, SPLITS)
    taken = [run.systems[name] for name in dict.fromkeys(systems or run.systems)]
    _check("model", models, list(dict.fromkeys(name for system in taken for name in system.models)))
    if models and not systems:
        taken = [system for system in taken if set(models) & set(system.models)]
    accepted = {system.name: system._accepted for system in taken}
    _check("utterance", utterances, list(dict.fromkeys(name for known in accepted.values() for name in known)))
    found = []
    for system in taken:
        of_splits = {name for name, one in accepted[system.name].items() if one.split in (splits or SPLITS)}
        names = [name for name in utterances or accepted[system.name] if name in of_splits]
        missing = [name for name in names if name not in system._targets]
        if missing:
            raise StorageError(
                f"the run in {run.folder} is not finished: {system.name} has no targets of {missing[0]}."
            )
        # Files are named by the ids, and the folder may come from a stranger.
        if illegal := [name for name in names if not LEGAL_ID.fullmatch(name) or len(name) > MAX_ID]:
            raise DamagedFile(
                system.coding_folder / "utterances.tsv", f"{shortened(illegal[0])!r} is no id of an utterance"
            )
        if names:
            found.append(
                (system, list(dict.fromkeys(names)), [one for one in system.models if one in (models or system.models)])
            )
    if not found:
        raise SettingError("no utterance is of this choice; leave --split or --utterance out.")
    return found


def _check(what: str, given: Sequence[str], known: Sequence[str]) -> None:
    for name in given:
        if name not in known:
            shown = ", ".join(list(known)[:12]) + ", ..." * (len(known) > 12)
            raise SettingError(f"the run has no {what} {name!r}; it has {shown or 'none'}.")


def _check_output(run: Run, output: Path) -> None:
    """Refuse a folder that holds something, or lies among the results."""
    results = run.folder.resolve()
    if results == output.resolve() or results in output.resolve().parents:
        raise SettingError(f"{output} lies in the results of the run; give a folder outside.")
    if output.is_symlink() or (output.exists() and not output.is_dir()):
        raise SettingError(f"{output} exists and is no folder; give another name.")
    if output.is_dir() and any(output.iterdir()):
        raise SettingError(f"{output} holds files; give the name of a new folder.")
    check_writable(output)


def _about(system: System, name: str) -> tuple:
    return tuple(getattr(system._accepted[name], column) for column in COLUMNS)


def _exported(system: System, name: str, models: Sequence[str], points: bool) -> Exported:
    labels, alignment = system.labels(name), system.run.alignment(name)
    parameters = {"truth": system.truth(name)}
    if system._accepted[name].split != "train":
        parameters |= {model: system.prediction(model, name) for model in models}
    segments = [(tier, one.label, one.start, one.end) for tier in TIERS for one in alignment.tier(tier)]
    tiers, names, starts, ends = zip(*segments, strict=True)
    return Exported(
        system.rate(name),
        labels["time"].to_numpy(),
        {tier: labels[tier].to_numpy(str) for tier in TIERS},
        {"tier": np.array(tiers), "label": np.array(names), "start": np.array(starts), "end": np.array(ends)},
        parameters,
        {key: system.points(values, name) for key, values in parameters.items()} if points else {},
    )


def _write_npz(folder: Path, name: str, given: Exported) -> None:
    arrays = {"rate": np.float64(given.rate), "times": given.times, **given.labels}
    arrays |= {f"segment_{key}": values for key, values in given.segments.items()}
    for what, trajectories in (("parameters", given.parameters), ("points", given.points)):
        arrays |= {f"{what}.{key}": values for key, values in trajectories.items()}
    with open(folder / f"{name}.npz", "wb") as file:
        np.savez_compressed(file, **arrays)


def _write_csv(folder: Path, name: str, given: Exported) -> None:
    times = np.round(given.times, 6)
    _write(_in(folder, "labels", name), ["time_s", *given.labels], [times, *given.labels.values()])
    segments = {key if key in ("tier", "label") else f"{key}_s": values for key, values in given.segments.items()}
    _write(_in(folder, "segments", name), list(segments), segments.values())
    for what, trajectories in (("parameters", given.parameters), ("points", given.points)):
        for key, values in trajectories.items():
            place = f"truth/{what}" if key == "truth" else f"predictions/{key}/{what}"
            heads = [f"p{number}" for number in range(1, values.shape[1] + 1)]
            if what == "points":
                axes = "xyz"[: values.shape[2]]
                heads = [f"{axis}{number}" for number in range(values.shape[1]) for axis in axes]
            _write(_in(folder, place, name), ["time_s", *heads], [times, *values.reshape(len(values), -1).T])


def _in(folder: Path, place: str, name: str) -> Path:
    (folder / place).mkdir(parents=True, exist_ok=True)
    return folder / place / f"{name}.csv"


def _write(path: Path, heads: Sequence[str], columns) -> None:
    """A CSV file with a line of names."""
    import pandas

    frame = pandas.DataFrame({number: values for number, values in enumerate(columns)})
    frame.to_csv(path, index=False, header=list(heads), lineterminator="\n")


_LAYOUT = {
    "csv": {
        "<system>/labels/<utterance>.csv": "time_s, word, phone and state of each frame",
        "<system>/segments/<utterance>.csv": "tier, label, start_s and end_s of each segment of the alignment",
        "<system>/truth/parameters/<utterance>.csv": "time_s and the recorded parameters p1, p2, ... of each frame",
        "<system>/predictions/<model>/parameters/<utterance>.csv": "the same as a model predicts them",
        "<system>/truth/points/<utterance>.csv": "time_s and the points x0, y0, x1, y1, ... of these parameters",
        "<system>/predictions/<model>/points/<utterance>.csv": "the same as a model predicts them",
    },
    "npz": {
        "<system>/<utterance>.npz": "arrays of T frames:",
        "  rate": "frame rate in Hz; times: (T,) seconds",
        "  word, phone, state": "(T,) text",
        "  segment_tier, segment_label, segment_start, segment_end": "segments of the alignment, in seconds",
        "  parameters.truth, parameters.<model>": "(T, N) recorded and predicted parameters",
        "  points.truth, points.<model>": "(T, P, d) points of these parameters",
    },
}


def _description(run: Run, chosen, form: str, points: bool) -> str:
    lines = [f"Corpus {run.corpus}, exported from the results of visualspeech.", ""]
    lines += ["<system>/utterances.csv: the utterances, their split, frame rate (Hz) and number of frames"]
    lines += [f"{name}: {text}" for name, text in _LAYOUT[form].items() if points or "points" not in name]
    lines += ["", "Frame i stands for the time (i + 0.5) / rate seconds. A pause is labelled sil; states are 1 to 3."]
    lines += ["Predictions are those of validation and test utterances; models have not seen these in training."]
    lines += [line for system, _, models in chosen for line in _about_system(system, models, points)]
    return "\n".join(lines) + "\n"


def _about_system(system: System, models: Sequence[str], points: bool) -> Iterator[str]:
    coding = system.coding
    yield ""
    yield f"{system.name}: {coding.size} parameters of the visual coding {system.coding_folder.name}"
    if points and coding.points is not None:
        yield f"  points: {coding.points.size} points of {coding.points.name}, pixels of the normalised face, y down"
    elif points:
        yield f"  points: markers {', '.join(coding.markers.names)}"
    yield f"  models: {', '.join(models) or 'none'}"
