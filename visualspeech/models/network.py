"""A trained network: what prediction needs and nothing else, in one safetensors file."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np
import torch

from visualspeech.errors import DataError
from visualspeech.features.label_parts import part_sizes
from visualspeech.models.blstm import Stack, StackSettings
from visualspeech.storage import part_of, read_model_of, write_model


@contextmanager
def one_thread() -> Iterator[None]:
    """Let torch compute on one thread: small networks run faster so, and sums do not depend on the machine's cores."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(before)


@dataclass(frozen=True)
class Network:
    """A network from label indices to appearance parameters.

    Parameters
    ----------
    stack : hidden layers
    phones : inventory that the label indices refer to, K entries
    weights : arrays by name, of :class:`visualspeech.models.blstm.Stack`
    mean : (N,) appearance that an output of zero stands for
    scale : how much appearance an output of one stands for
    rate : frame rate of labels and appearance in Hz
    aam : digest of the appearance model whose parameters are predicted
    about : how it was trained (settings, epochs, digests), for people
    parts : what its labels say beyond phones and states, of :data:`visualspeech.features.label_parts.PARTS`
    """

    stack: StackSettings
    phones: tuple[str, ...]
    weights: Mapping[str, np.ndarray]
    mean: np.ndarray
    scale: float
    rate: float
    aam: str = ""
    about: Mapping = field(default_factory=dict)
    parts: tuple[str, ...] = ()

    @property
    def outputs(self) -> int:
        """Dimension N of the appearance."""
        return len(self.mean)

    @cached_property
    def _module(self) -> Stack:
        module = Stack(self.stack, len(self.phones), self.outputs, parts=part_sizes(self.parts))
        module.load_state_dict({name: torch.tensor(values) for name, values in self.weights.items()})
        return module.eval()

    def predict(self, labels: np.ndarray) -> np.ndarray:
        """Appearance (T, N) float32 of one utterance's labels (T, 4) (left, current, right phone index, state).

        A network of richer labels reads a column more for each of its parts, in their order.

        Raises
        ------
        DataError
            There is no frame, or an index is outside the inventory.
        """
        check_labels(labels, len(self.phones), part_sizes(self.parts))
        with one_thread(), torch.inference_mode():
            indices = torch.tensor(np.asarray(labels, np.int64))[None]
            values = self._module(indices, torch.tensor([len(labels)]))[0].numpy()
        return (values * np.float32(self.scale) + self.mean).astype(np.float32)

    def save(self, path: str | Path) -> None:
        """Write it as one safetensors file."""
        tensors = {f"weights.{name}": values for name, values in self.weights.items()}
        settings = {
            "kind": "network",
            "stack": asdict(self.stack),
            "phones": list(self.phones),
            "outputs": self.outputs,
            "scale": float(self.scale),
            "rate": float(self.rate),
            "aam": self.aam,
            "about": dict(self.about),
            "parts": list(self.parts),
        }
        write_model(path, {**tensors, "mean": self.mean}, settings)

    @staticmethod
    def load(path: str | Path) -> "Network":
        """Read what :meth:`save` wrote; raises as :func:`visualspeech.storage.read_model_of`."""
        tensors, settings = read_model_of(path, "network", ["network"])
        return Network(
            stack=StackSettings(**settings["stack"]),
            phones=tuple(settings["phones"]),
            weights=part_of(tensors, "weights"),
            mean=tensors["mean"],
            scale=settings["scale"],
            rate=settings["rate"],
            aam=settings["aam"],
            about=settings["about"],
            parts=tuple(settings.get("parts", ())),
        )


def check_labels(labels: np.ndarray, phones: int, parts: Sequence[int] = ()) -> None:
    """Whether labels are (T, 4 + parts) indices inside an inventory of ``phones`` phones, with at least one frame.

    ``parts`` are the numbers of values of each further part.

    Raises
    ------
    DataError
        They are not.
    """
    labels = np.asarray(labels)
    width = 4 + len(parts)
    if labels.ndim != 2 or labels.shape[1] != width or not len(labels):
        raise DataError(
            f"labels must be frames of {'four' if width == 4 else width} indices, not an array of shape {labels.shape}."
        )
    if labels[:, 4:].size and (labels[:, 4:].max(axis=0) >= np.array(parts)).any():
        raise DataError("labels have parts of other kinds than the model. Delete the label parts and run again.")
    if labels.min() < 0 or labels[:, :3].max() >= phones or labels[:, 3].max() >= 3:
        raise DataError(
            f"labels name phones or states that the inventory of {phones} phones does not have; the features were made "
            "for another model. Delete the features and run again."
        )
