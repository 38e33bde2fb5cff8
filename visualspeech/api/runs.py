"""A finished run: what the results folder of a corpus holds, as arrays and data frames.

``docs/data.md`` describes the files. This module alone knows where they lie.
"""

import io
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import fields
from functools import cached_property
from pathlib import Path

import numpy as np

from visualspeech.corpora.findings import Finding, read_findings
from visualspeech.corpora.records import Utterance
from visualspeech.corpora.table import OF_PROBLEM, read_utterances
from visualspeech.errors import DataError, StorageError
from visualspeech.face.coding import VisualCoding, load_coding
from visualspeech.provenance import file_digest
from visualspeech.speech.alignment import TIERS, Alignment, read_alignments, starts_of
from visualspeech.storage.arrays import ArrayCollection
from visualspeech.storage.models import read_model_settings
from visualspeech.storage.tables import read_numbers
from visualspeech.timing import frame_times, interval_of_frame

SPLITS = ("train", "validation", "test")
#: Folders of a results folder that are no systems.
_OF_CORPUS = {
    "alignment", "audio", "benchmarks", "check", "codings", "corpus", "heads", "landmarks", "logs", "motion", "pose",
    "recordings", "tables", "truth",
}  # fmt: skip
_UNFINISHED = "Run the workflow's target `all` to its end, with the same settings."


class Run:
    """The results of a corpus: ``Run("results/demo")``.

    Files are opened when they are first asked for, and kept open until :meth:`close` or the end of a ``with`` block.

    Parameters
    ----------
    folder : results folder of one corpus

    Raises
    ------
    StorageError
        It is no results folder, or the run has not come as far as the list of its utterances.
    """

    def __init__(self, folder: str | Path) -> None:
        self.folder = Path(folder)
        if (self.folder / "utterances.tsv").is_file():
            return
        if not self.folder.is_dir():
            what = "is a file" if self.folder.exists() else "does not exist"
            raise StorageError(f"{folder} {what}. Give the results folder of a corpus, for example results/demo.")
        if (self.folder / "corpus").is_dir():
            raise StorageError(f"the run in {folder} is not finished: it has no utterances.tsv. {_UNFINISHED}")
        inside = sorted(path.parent.name for path in self.folder.glob("*/utterances.tsv"))
        several = f"; it holds those of {', '.join(inside)}" if inside else ""
        raise StorageError(
            f"{folder} is no results folder of a corpus{several}. Give one, for example "
            f"{self.folder / inside[0] if inside else 'results/demo'}."
        )

    def __repr__(self) -> str:
        return f"Run({str(self.folder)!r})"

    def __enter__(self) -> "Run":
        return self

    def __exit__(self, *exception) -> None:
        self.close()

    def close(self) -> None:
        """Close all files; what is asked for afterwards opens them again."""
        while self._opened:
            self._opened.popitem()[1].__exit__(None, None, None)

    @property
    def corpus(self) -> str:
        """Name of the corpus."""
        return self.folder.resolve().name

    @cached_property
    def utterances(self):
        """The accepted utterances as a data frame: id, speaker, media, transcript, split, ... (``utterances.tsv``)."""
        return _frame(read_utterances(self.folder / "utterances.tsv"), Utterance, OF_PROBLEM)

    @cached_property
    def findings(self):
        """Rejections and warnings of the recordings as a data frame."""
        return _frame(read_findings(self.folder / "findings.tsv"), Finding)

    @cached_property
    def systems(self) -> dict[str, "System"]:
        """The systems that were run, by name."""
        found = (path for path in sorted(self.folder.iterdir()) if path.is_dir() and path.name not in _OF_CORPUS)
        return {path.name: System(self, path) for path in found if (path / "targets").is_dir()}

    def system(self, name: str) -> "System":
        """One system, for example ``fan2015``.

        Raises
        ------
        DataError
            The run has no such system.
        """
        if name not in self.systems:
            raise DataError(f"{self.folder} has no system {name!r}; it has {_listed(self.systems)}.")
        return self.systems[name]

    @cached_property
    def _alignments(self) -> dict[str, Alignment]:
        return {name: one for path in self._shards("alignment", ".tsv") for name, one in read_alignments(path).items()}

    def alignment(self, utterance: str) -> Alignment:
        """Words, phones and states of an utterance, also of one that was rejected after the alignment."""
        return _of(self._alignments, utterance, self.folder)

    def sound(self, utterance: str) -> tuple[np.ndarray, int]:
        """Samples (n,) int16, mono, and their rate in Hz."""
        arrays = self._arrays("audio")
        return arrays.array(_known(arrays, utterance, self.folder), "samples"), int(arrays.rate(utterance))

    def landmarks(self, utterance: str) -> np.ndarray:
        """The tracked landmarks (T, 68, 2) in pixels of the frame, at :meth:`rate`."""
        arrays = self._arrays("landmarks")
        return arrays.array(_known(arrays, utterance, self.folder), "points")

    def frontal(self, utterance: str) -> np.ndarray:
        """The landmarks (T, 68, 2) without the movement of the head, in pixels of the normalised face."""
        arrays = self._arrays("pose")
        return arrays.array(_known(arrays, utterance, self.folder), "points")

    def rate(self, utterance: str) -> float:
        """Frame rate in Hz of the recorded faces."""
        folder = "landmarks" if (self.folder / "landmarks").is_dir() else "motion"
        arrays = self._arrays(folder)
        return arrays.rate(_known(arrays, utterance, self.folder))

    def table(self, name: str = "systems"):
        """A table across systems as a data frame."""
        return _table(self.folder, name)

    @cached_property
    def _opened(self) -> dict[str, ArrayCollection]:
        return {}

    def _arrays(self, folder: str) -> ArrayCollection:
        """The files of all shards in a folder, opened."""
        if folder not in self._opened:
            self._opened[folder] = ArrayCollection(self._shards(folder, ".h5"))
        return self._opened[folder]

    def _shards(self, folder: str, suffix: str) -> list[Path]:
        paths = [path for path in (self.folder / folder).glob(f"*{suffix}") if path.stem.isdigit()]
        if not paths:
            raise StorageError(f"the run in {self.folder} has no {folder}/*{suffix}. {_UNFINISHED}")
        return sorted(paths, key=lambda path: int(path.stem))


class System:
    """A system that was run on a corpus: ``run.system("fan2015")``.

    Parameters
    ----------
    run : results of the corpus
    folder : of the system
    """

    def __init__(self, run: Run, folder: Path) -> None:
        self.run, self.folder, self.name = run, folder, folder.name

    def __repr__(self) -> str:
        return f"{self.run!r}.system({self.name!r})"

    @cached_property
    def models(self) -> list[str]:
        """Names of the rows that have predictions."""
        return sorted(path.parent.name for path in self.folder.glob("models/*/predictions.h5"))

    @cached_property
    def coding_folder(self) -> Path:
        """Folder of the visual coding whose parameters its models predict.

        Raises
        ------
        StorageError
            No model is trained yet, or the coding was made again since.
        """
        trained = sorted(self.folder.glob("models/*/model.safetensors"))
        if not trained:
            raise StorageError(f"the run in {self.folder} has no trained model. {_UNFINISHED}")
        wanted = read_model_settings(trained[0])["coding"]
        for path in sorted(self.run.folder.glob("codings/*/model.safetensors")):
            if file_digest(path) == wanted:
                return path.parent
        raise StorageError(f"{trained[0]} was trained for a visual coding that {self.run.folder} lacks. {_UNFINISHED}")

    @cached_property
    def coding(self) -> VisualCoding:
        """The visual coding, for example an :class:`~visualspeech.Aam`."""
        return load_coding(self.coding_folder / "model.safetensors")

    @cached_property
    def _accepted(self) -> dict[str, Utterance]:
        return {one.id: one for one in read_utterances(self.coding_folder / "utterances.tsv")}

    @property
    def utterances(self):
        """The utterances of the system as a data frame: those whose faces the visual coding could read."""
        return _frame(self._accepted.values(), Utterance, OF_PROBLEM)

    def ids(self, split: str = "test") -> list[str]:
        """Ids of the utterances of a split: train, validation or test.

        Raises
        ------
        DataError
            There is no such split.
        """
        if split not in SPLITS:
            raise DataError(f"there is no split {split!r}; give one of {', '.join(SPLITS)}.")
        return [name for name, one in self._accepted.items() if one.split == split]

    def speaker(self, utterance: str) -> str:
        """Who speaks in an utterance."""
        return _of(self._accepted, utterance, self.folder).speaker

    def rate(self, utterance: str) -> float:
        """Frame rate of parameters, labels and predictions in Hz."""
        return self._targets.rate(_known(self._targets, utterance, self.folder))

    def times(self, utterance: str) -> np.ndarray:
        """Times of the frames in seconds, (T,): (i + 0.5) / rate."""
        return frame_times(len(self.truth(utterance)), self.rate(utterance))

    @property
    def _targets(self) -> ArrayCollection:
        return self.run._arrays(f"{self.name}/targets")

    def truth(self, utterance: str) -> np.ndarray:
        """The recorded parameters (T, N) float32 of an utterance: what models are to predict."""
        return self._targets.array(_known(self._targets, utterance, self.folder), "appearance")

    def prediction(self, model: str, utterance: str) -> np.ndarray:
        """The parameters (T, N) float32 that a model predicts of a validation or test utterance."""
        arrays = self._predictions(model)
        if utterance in self._accepted and utterance not in arrays:
            split = self._accepted[utterance].split
            raise DataError(f"{utterance} is a {split} utterance; predictions are those of validation and test.")
        return arrays.array(_known(arrays, utterance, self.folder), "appearance")

    def truths(self, split: str = "test") -> dict[str, np.ndarray]:
        """The recorded parameters of the utterances of a split, by id."""
        return {name: self.truth(name) for name in self.ids(split)}

    def predictions(self, model: str, split: str = "test") -> dict[str, np.ndarray]:
        """The predicted parameters of the validation or test utterances, by id."""
        return {name: self.prediction(model, name) for name in self.ids(split)}

    def _predictions(self, model: str) -> ArrayCollection:
        if model not in self.models:
            raise DataError(f"{self.folder} has no predictions of the model {model!r}; it has {_listed(self.models)}.")
        key = f"{self.name}/models/{model}"
        if key not in self.run._opened:
            self.run._opened[key] = ArrayCollection([self.run.folder / key / "predictions.h5"])
        return self.run._opened[key]

    def points(self, parameters: np.ndarray, utterance: str = "") -> np.ndarray:
        """Points (T, P, d) of parameters (T, N): pixels of the normalised face, or the unit of the motion capture.

        Parameters
        ----------
        utterance : whose speaker's proportions a coding of markers uses
        """
        return self.coding.decode_points(parameters, self.speaker(utterance) if utterance else "")

    def labels(self, utterance: str):
        """Word, phone and state of each frame as a data frame: time, word, phone, state."""
        import pandas

        times, alignment = self.times(utterance), self.run.alignment(utterance)
        columns = {"time": times}
        for tier in TIERS:
            segments = alignment.tier(tier)
            columns[tier] = [segments[at].label for at in interval_of_frame(starts_of(segments), times)]
        return pandas.DataFrame(columns)

    def features(self, block: str, utterance: str) -> dict[str, np.ndarray]:
        """The stream of an input block: ``index`` (T, C) classes, ``values`` (T, D), ``starts`` (T,) of segments."""
        arrays = self.run._arrays(f"{self.name}/features/{block}")
        return arrays[_known(arrays, utterance, self.folder)]

    @cached_property
    def blocks(self) -> list[str]:
        """Names of the input blocks."""
        return sorted(path.parent.name for path in self.folder.glob("features/*/block.safetensors"))

    def examples(self, split: str, reads: Sequence[str]):
        """The utterances of a split as models learn from them, for :func:`visualspeech.train` and ``predict``.

        Parameters
        ----------
        reads : names of input blocks, see :attr:`blocks`

        Raises
        ------
        DataError
            There is no such block or split.
        """
        from visualspeech.api.learning import RunExamples
        from visualspeech.models.block_states import load_blocks
        from visualspeech.storage.regions import coding_regions

        reads = [reads] if isinstance(reads, str) else list(reads)
        unknown = [name for name in reads if name not in self.blocks]
        if unknown or not reads:
            what = f"no input block {unknown[0]!r}" if unknown else "to be asked for at least one input block"
            raise DataError(f"{self.folder} has {what}; it has {_listed(self.blocks)}.")
        files = {name: self.folder / "features" / name / "block.safetensors" for name in reads}
        model = self.coding_folder / "model.safetensors"
        return RunExamples(
            [self.run._arrays(f"{self.name}/features/{name}") for name in reads],
            self._targets,
            self.ids(split),
            load_blocks(files),
            file_digest(model),
            coding_regions(model),
            self.run._shards("alignment", ".tsv"),
        )

    def model(self, name: str):
        """A trained model (:class:`visualspeech.models.task.Model`)."""
        from visualspeech.models.registry import load_model

        path = self.folder / "models" / name / "model.safetensors"
        if not path.is_file():
            known = sorted(one.parent.name for one in self.folder.glob("models/*/model.safetensors"))
            raise DataError(f"{self.folder} has no trained model {name!r}; it has {_listed(known)}.")
        return load_model(path)

    def learning_curve(self, model: str):
        """Errors per epoch or iteration of the training of a model as a data frame."""
        path = self.folder / "models" / model / "learning_curve.tsv"
        if not path.is_file():
            raise DataError(f"{self.folder} has no trained model {model!r}.")
        return read_numbers(path)

    def scores(self, model: str) -> Mapping[str, float]:
        """Figure of every measure of a model's test utterances, as in the result tables."""
        from visualspeech.api.scores import measured

        path = self.folder / "models" / model / "statistics.tsv"
        if not path.is_file():
            raise DataError(f"{self.folder} has no statistics of the model {model!r}; it has {_listed(self.models)}.")
        return measured(read_numbers(path))

    @property
    def tables(self) -> list[str]:
        """Names of the result tables."""
        return sorted(path.stem for path in self.folder.glob("tables/*.tsv"))

    def table(self, name: str = "objective"):
        """A result table as a data frame; what the table says about itself is in its ``attrs``."""
        return _table(self.folder, name)


def _frame(records: Iterable, cls: type, left_out: Collection[str] = ()):
    """Records of a dataclass as a data frame, which has its columns also where there is no record."""
    import pandas

    columns = [field.name for field in fields(cls) if field.name not in left_out]
    return pandas.DataFrame([[getattr(one, name) for name in columns] for one in records], columns=columns)


def _table(folder: Path, name: str):
    """A result table, whose first lines are ``# key: value``."""
    import pandas

    path = folder / "tables" / f"{name}.tsv"
    if not path.is_file():
        known = sorted(one.stem for one in path.parent.glob("*.tsv"))
        raise DataError(f"{folder} has no table {name!r}; it has {_listed(known)}.")
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    notes = [line[1:].strip() for line in lines if line.startswith("#")]
    text = "".join(line for line in lines if not line.startswith("#"))
    frame = pandas.read_csv(io.StringIO(text), sep="\t")
    frame.attrs.update(dict(note.partition(": ")[::2] for note in notes))
    return frame


def _known(arrays: ArrayCollection, utterance: str, folder: Path) -> str:
    if utterance not in arrays:
        raise DataError(f"{folder} has no utterance {utterance!r}; it has {_listed(arrays.ids)}.")
    return utterance


def _of(found: Mapping, utterance: str, folder: Path):
    if utterance not in found:
        raise DataError(f"{folder} has no utterance {utterance!r}; it has {_listed(sorted(found))}.")
    return found[utterance]


def _listed(names, most: int = 8) -> str:
    names = list(names)
    shown = ", ".join(names[:most]) or "none"
    return f"{shown}, ... ({len(names)})" if len(names) > most else shown
