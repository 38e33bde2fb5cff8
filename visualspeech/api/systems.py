"""A system of a finished run: its models, predictions, labels and tables."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path

import numpy as np

from visualspeech.api.reading import UNFINISHED, found_in, frame_of, known_in, listed, table_of
from visualspeech.corpora.records import Utterance
from visualspeech.corpora.table import OF_PROBLEM, read_utterances
from visualspeech.errors import DataError, StorageError
from visualspeech.face.coding import VisualCoding
from visualspeech.face.coding_files import load_coding
from visualspeech.provenance import file_digest
from visualspeech.speech.alignment import TIERS, starts_of
from visualspeech.storage.arrays import ArrayCollection
from visualspeech.storage.models import read_model_settings
from visualspeech.storage.tables import read_numbers
from visualspeech.timing import frame_times, interval_of_frame

SPLITS = ("train", "validation", "test")


class System:
    """A system that was run on a corpus: ``run.system("fan2015")``.

    Parameters
    ----------
    run : :class:`~visualspeech.Run` of the corpus
    folder : of the system
    """

    def __init__(self, run, folder: Path) -> None:
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
            raise StorageError(f"the run in {self.folder} has no trained model. {UNFINISHED}")
        wanted = read_model_settings(trained[0])["coding"]
        for path in sorted(self.run.folder.glob("codings/*/model.safetensors")):
            if file_digest(path) == wanted:
                return path.parent
        raise StorageError(f"{trained[0]} was trained for a visual coding that {self.run.folder} lacks. {UNFINISHED}")

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
        return frame_of(self._accepted.values(), Utterance, OF_PROBLEM)

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
        return found_in(self._accepted, utterance, self.folder).speaker

    def rate(self, utterance: str) -> float:
        """Frame rate of parameters, labels and predictions in Hz."""
        return self._targets.rate(known_in(self._targets, utterance, self.folder))

    def times(self, utterance: str) -> np.ndarray:
        """Times of the frames in seconds, (T,): (i + 0.5) / rate."""
        return frame_times(len(self.truth(utterance)), self.rate(utterance))

    @property
    def _targets(self) -> ArrayCollection:
        return self.run._arrays(f"{self.name}/targets")

    def truth(self, utterance: str) -> np.ndarray:
        """The recorded parameters (T, N) float32 of an utterance: what models are to predict."""
        return self._targets.array(known_in(self._targets, utterance, self.folder), "appearance")

    def prediction(self, model: str, utterance: str) -> np.ndarray:
        """The parameters (T, N) float32 that a model predicts of a validation or test utterance."""
        arrays = self._predictions(model)
        if utterance in self._accepted and utterance not in arrays:
            split = self._accepted[utterance].split
            raise DataError(f"{utterance} is a {split} utterance; predictions are those of validation and test.")
        return arrays.array(known_in(arrays, utterance, self.folder), "appearance")

    def truths(self, split: str = "test") -> dict[str, np.ndarray]:
        """The recorded parameters of the utterances of a split, by id."""
        return {name: self.truth(name) for name in self.ids(split)}

    def predictions(self, model: str, split: str = "test") -> dict[str, np.ndarray]:
        """The predicted parameters of the validation or test utterances, by id."""
        return {name: self.prediction(model, name) for name in self.ids(split)}

    def _predictions(self, model: str) -> ArrayCollection:
        if model not in self.models:
            raise DataError(f"{self.folder} has no predictions of the model {model!r}; it has {listed(self.models)}.")
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
        return arrays[known_in(arrays, utterance, self.folder)]

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
            raise DataError(f"{self.folder} has {what}; it has {listed(self.blocks)}.")
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
            raise DataError(f"{self.folder} has no trained model {name!r}; it has {listed(known)}.")
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
            raise DataError(f"{self.folder} has no statistics of the model {model!r}; it has {listed(self.models)}.")
        return measured(read_numbers(path))

    @property
    def tables(self) -> list[str]:
        """Names of the result tables."""
        return sorted(path.stem for path in self.folder.glob("tables/*.tsv"))

    def table(self, name: str = "objective"):
        """A result table as a data frame; what the table says about itself is in its ``attrs``."""
        return table_of(self.folder, name)
