"""A finished run: what the results folder of a corpus holds, as arrays and data frames.

``docs/data.md`` describes the files. This module and :mod:`visualspeech.api.systems` alone know where they lie.
"""

from functools import cached_property
from pathlib import Path

import numpy as np

from visualspeech.api.reading import UNFINISHED, found_in, frame_of, known_in, listed, table_of
from visualspeech.api.systems import System
from visualspeech.corpora.findings import Finding, read_findings
from visualspeech.corpora.records import Utterance
from visualspeech.corpora.table import OF_PROBLEM, read_utterances
from visualspeech.errors import DataError, StorageError
from visualspeech.speech.alignment import Alignment, read_alignments
from visualspeech.storage.arrays import ArrayCollection

#: Folders of a results folder that are no systems.
_OF_CORPUS = {
    "alignment", "audio", "benchmarks", "check", "codings", "corpus", "heads", "landmarks", "logs", "motion", "pose",
    "recordings", "tables", "truth",
}  # fmt: skip


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
            raise StorageError(f"the run in {folder} is not finished: it has no utterances.tsv. {UNFINISHED}")
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
        return frame_of(read_utterances(self.folder / "utterances.tsv"), Utterance, OF_PROBLEM)

    @cached_property
    def findings(self):
        """Rejections and warnings of the recordings as a data frame."""
        return frame_of(read_findings(self.folder / "findings.tsv"), Finding)

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
            raise DataError(f"{self.folder} has no system {name!r}; it has {listed(self.systems)}.")
        return self.systems[name]

    @cached_property
    def _alignments(self) -> dict[str, Alignment]:
        return {name: one for path in self._shards("alignment", ".tsv") for name, one in read_alignments(path).items()}

    def alignment(self, utterance: str) -> Alignment:
        """Words, phones and states of an utterance, also of one that was rejected after the alignment."""
        return found_in(self._alignments, utterance, self.folder)

    def sound(self, utterance: str) -> tuple[np.ndarray, int]:
        """Samples (n,) int16, mono, and their rate in Hz."""
        arrays = self._arrays("audio")
        return arrays.array(known_in(arrays, utterance, self.folder), "samples"), int(arrays.rate(utterance))

    def landmarks(self, utterance: str) -> np.ndarray:
        """The tracked landmarks (T, 68, 2) in pixels of the frame, at :meth:`rate`."""
        arrays = self._arrays("landmarks")
        return arrays.array(known_in(arrays, utterance, self.folder), "points")

    def frontal(self, utterance: str) -> np.ndarray:
        """The landmarks (T, 68, 2) without the movement of the head, in pixels of the normalised face."""
        arrays = self._arrays("pose")
        return arrays.array(known_in(arrays, utterance, self.folder), "points")

    def motion(self, utterance: str) -> np.ndarray:
        """The motion capture (T, P, D) in the unit of the recording, of a corpus that has it in place of video."""
        arrays = self._arrays("motion")
        return arrays.array(known_in(arrays, utterance, self.folder), "points")

    def rate(self, utterance: str) -> float:
        """Frame rate in Hz of the recorded faces: landmarks, or motion capture."""
        folder = "landmarks" if (self.folder / "landmarks").is_dir() else "motion"
        arrays = self._arrays(folder)
        return arrays.rate(known_in(arrays, utterance, self.folder))

    def table(self, name: str = "systems"):
        """A table across systems as a data frame."""
        return table_of(self.folder, name)

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
            raise StorageError(f"the run in {self.folder} has no {folder}/*{suffix}. {UNFINISHED}")
        return sorted(paths, key=lambda path: int(path.stem))
