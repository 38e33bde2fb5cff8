"""Reads a finished run for the benchmarks, and trains its models again on other data or with other settings."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from functools import cached_property
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from visualspeech.corpora.records import Utterance, legal_id
from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.errors import DataError, StorageError
from visualspeech.evaluation.scoring import frame_correlation, frame_rmse
from visualspeech.face.head import HeadModel
from visualspeech.features.blocks.base import Block
from visualspeech.features.examples import Example, Examples, opened_blocks
from visualspeech.models.families import FAMILIES
from visualspeech.models.hmm.family import HmmModel
from visualspeech.models.hmm.model import HmmSettings
from visualspeech.models.registry import load_model
from visualspeech.models.rows import ModelRow
from visualspeech.models.task import Model, Task
from visualspeech.speech.alignment import Alignment, read_alignments
from visualspeech.storage.arrays import ArrayCollection
from visualspeech.storage.models import read_model_settings

#: Variants of HMMs in the order of their training, each from the one before.
VARIANTS = ("monophone", "tied", "mge")


def shards(folder: Path, suffix: str = ".h5") -> list[Path]:
    """The files of all shards in a folder, in the order of their numbers.

    Raises
    ------
    StorageError
        There are none.
    """
    found = [path for path in folder.glob(f"*{suffix}") if path.stem.isdigit()]
    if not found:
        raise StorageError(f"{folder} holds no shards. Give the folder of a finished run, for example results/grid.")
    return sorted(found, key=lambda path: int(path.stem))


@dataclass(frozen=True)
class CorpusRun:
    """What a run has measured of a corpus.

    Parameters
    ----------
    folder : for example ``results/grid``
    """

    folder: Path

    @cached_property
    def utterances(self) -> list[Utterance]:
        """The accepted utterances, with their split."""
        return read_utterances(self.folder / "utterances.tsv")

    def of_split(self, split: str) -> list[Utterance]:
        """The accepted utterances of one split."""
        return of_split(self.utterances, split)

    def ids(self, split: str) -> list[str]:
        """The ids of the accepted utterances of one split."""
        return [utterance.id for utterance in self.of_split(split)]

    @cached_property
    def alignments(self) -> dict[str, Alignment]:
        """Alignment of each utterance, by id."""
        tables = shards(self.folder / "alignment", ".tsv")
        return {name: found for path in tables for name, found in read_alignments(path).items()}

    def head(self, speaker: str) -> HeadModel:
        """The head of a speaker."""
        return HeadModel.load(self.folder / "heads" / f"{legal_id(speaker)}.safetensors")

    def landmarks(self) -> ArrayCollection:
        """The landmarks, opened."""
        return ArrayCollection(shards(self.folder / "landmarks"))

    def pose(self) -> ArrayCollection:
        """The head pose, opened."""
        return ArrayCollection(shards(self.folder / "pose"))


@dataclass(frozen=True)
class CodingRun:
    """A visual coding of a corpus.

    Parameters
    ----------
    corpus : what it was made from
    name : for example ``aam51``
    """

    corpus: CorpusRun
    name: str

    @property
    def folder(self) -> Path:
        return self.corpus.folder / "codings" / self.name

    @property
    def model(self) -> Path:
        """File of the appearance model."""
        return self.folder / "model.safetensors"

    @property
    def reference(self) -> Path:
        """File of the texture grid."""
        return self.folder / "reference.safetensors"

    def tracked_faces(self) -> ArrayCollection:
        """Shapes and textures at the landmarks, opened."""
        return ArrayCollection(shards(self.folder / "textures"))

    def coded_faces(self) -> ArrayCollection:
        """The faces that the parameters code, opened: fitted ones where there are any, else those at the landmarks."""
        fitted = self.folder / "fitted"
        return ArrayCollection(shards(fitted)) if fitted.is_dir() else self.tracked_faces()

    def parameters(self) -> ArrayCollection:
        """Parameters at the frame rate of the video, opened."""
        return ArrayCollection(shards(self.folder / "parameters"))


@dataclass(frozen=True)
class SystemRun:
    """A system that was run on a corpus.

    Parameters
    ----------
    corpus : on which it was run
    name : for example ``fan2015``
    """

    corpus: CorpusRun
    name: str

    @property
    def folder(self) -> Path:
        return self.corpus.folder / self.name

    def targets(self) -> ArrayCollection:
        """What its models predict, opened."""
        return ArrayCollection(shards(self.folder / "targets"))

    def predictions(self, model: str) -> ArrayCollection:
        """What a model predicted, opened."""
        return ArrayCollection([self.folder / "models" / model / "predictions.h5"])

    def model(self, name: str) -> Model:
        """A trained model."""
        return load_model(self._file(name))

    def _file(self, model: str) -> Path:
        return self.folder / "models" / model / "model.safetensors"

    def trained_models(self) -> list[str]:
        """Names of the trained models; the reconstruction is none."""
        return sorted(path.parent.name for path in self.folder.glob("models/*/model.safetensors"))

    def last_hmm(self) -> str:
        """Name of the HMMs of the latest variant: MGE-trained ones, where the run has them.

        Raises
        ------
        DataError
            The run has no HMMs.
        """
        names = [name for name in self.trained_models() if read_model_settings(self._file(name))["family"] == "hmm"]
        variants = {name: self.model(name).hmm.settings.variant for name in names}
        if not variants:
            raise DataError(f"{self.folder} has no HMMs among its models.")
        return max(variants, key=lambda name: VARIANTS.index(variants[name]))

    @contextmanager
    def examples(self, blocks: Sequence[str]) -> Iterator[Callable[[Sequence[str]], Examples]]:
        """Gives a function from ids to the utterances that a model reading these blocks learns from."""
        files = [path for block in blocks for path in shards(self.folder / "features" / block)]
        with opened_blocks(files, len(blocks)) as features, self.targets() as targets:
            yield lambda ids: Examples(features, targets, ids)


def retrained(network, name: str, training: Sequence[Example], validation: Sequence[Example]) -> Model:
    """A network trained on other utterances with the settings of a trained one."""
    trained = dict(network.about["training"])
    row = ModelRow(
        name,
        name,
        network.family,
        network.settings,
        tuple(network.blocks),
        training={key: value for key, value in trained.items() if key != "seed"},
        seed=trained["seed"],
    )
    module = import_module(FAMILIES[network.family].module)
    return module.fit(Task(row, network.blocks, training, validation)).model


def fit_hmm(
    settings: HmmSettings,
    blocks: Mapping[str, Block],
    training: Sequence[Example],
    validation: Sequence[Example],
    parent: HmmModel | None = None,
) -> HmmModel:
    """HMMs of the variant that the settings name, from the utterances or from ``parent``, as a run trains them."""
    own = {key: value for key, value in asdict(settings).items() if key != "seed"}
    row = ModelRow(settings.variant, settings.variant, "hmm", own, tuple(blocks), seed=settings.seed)
    with TemporaryDirectory() as folder:
        paths = [Path(folder, "parent.safetensors")] if parent else []
        if parent:
            parent.save(paths[0])
        fitted = import_module(FAMILIES["hmm"].module).fit(Task(row, blocks, training, validation, parents=paths))
    return fitted.model


def rmse_and_corr(model: Model, examples: Sequence[Example], centred: bool = False) -> tuple[float, float]:
    """RMSE and CORR (Eq. 18 and 19) of the appearance that a model predicts of utterances.

    Parameters
    ----------
    centred : take prediction and truth less their own means over the utterance
    """
    errors, correlations = [], []
    for number in range(len(examples)):
        streams, true, rate = examples[number]
        predicted = model.predict(streams, len(true), rate)
        if centred:
            predicted, true = predicted - predicted.mean(axis=0), true - true.mean(axis=0)
        errors.append(frame_rmse(predicted, true))
        correlations.append(np.nan_to_num(frame_correlation(predicted, true)))
    return float(np.concatenate(errors).mean()), float(np.concatenate(correlations).mean())
