"""A trained network of any family: what prediction needs and nothing else, in one safetensors file."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path

import numpy as np
import torch

from visualspeech.errors import DamagedFile, SettingError
from visualspeech.features.blocks.base import Block
from visualspeech.features.streams import Layout, Stream, joined
from visualspeech.fields import restored
from visualspeech.models.batches import Batch, Scaling
from visualspeech.models.block_states import BLOCK_ARRAYS, BLOCKS, pack, unpack
from visualspeech.models.task import check_streams
from visualspeech.models.training import one_thread
from visualspeech.models.trajectory.generation import check_generation, step_of
from visualspeech.models.trajectory.mlpg import Mlpg
from visualspeech.models.trajectory.settings import TrajectorySettings
from visualspeech.models.trajectory.windows import WINDOWS
from visualspeech.storage.layouts import RATE, TEXT, Array, FileLayout
from visualspeech.storage.models import check_model, part_of, write_model


@dataclass(frozen=True)
class Network:
    """A network from input streams to the parameters of a visual coding.

    Parameters
    ----------
    family : entry of the model registry
    settings : of the module, plain data
    module : evaluated on a :class:`~visualspeech.models.batches.Batch`
    scaling : from its outputs to parameters, or to static, delta and delta-delta parameters
    blocks : the input blocks that it reads, by name
    rate : frame rate of streams and parameters in Hz
    coding : digest of the visual coding whose parameters are predicted
    about : how it was trained (settings, epochs), for people
    mlpg : from static, delta and delta-delta parameters to the parameters; None where the outputs are the parameters
    """

    family: str
    settings: Mapping
    module: torch.nn.Module = field(repr=False)
    scaling: Scaling
    blocks: Mapping[str, Block]
    rate: float
    coding: str = ""
    about: Mapping = field(default_factory=dict)
    mlpg: Mlpg | None = None

    @property
    def outputs(self) -> int:
        """Dimension N of the parameters."""
        return self.mlpg.outputs if self.mlpg else len(self.scaling.mean)

    def predict(self, streams: Sequence[Stream], frames: int = 0, rate: float = 0.0) -> np.ndarray:
        """Parameters (T, N) float32 of one utterance's streams, of T frames each; length and rate are theirs.

        Raises
        ------
        DataError
            There is no frame, or a stream does not fit the blocks.
        """
        observed = self.observed(streams)
        return self.mlpg.trajectory(observed, self.rate).astype(np.float32) if self.mlpg else observed

    def observed(self, streams: Sequence[Stream]) -> np.ndarray:
        """What the module predicts of one utterance, float32: parameters (T, N), or with ``mlpg`` (T, 3N) of them.

        Raises
        ------
        DataError
            As :meth:`predict`.
        """
        check_streams(streams, self.blocks)
        index, values = (torch.from_numpy(part)[None] for part in joined(streams))
        lengths = torch.tensor([index.shape[1]])
        with one_thread(), torch.inference_mode():
            outputs = self.module(Batch(index, values, lengths, torch.zeros(0)))[0].numpy()
        scale, mean = (part.astype(np.float32) for part in (self.scaling.scale, self.scaling.mean))
        return (outputs * scale + mean).astype(np.float32)

    def save(self, path: str | Path) -> None:
        """Write it as one safetensors file."""
        arrays, blocks = pack(self.blocks)
        arrays |= {f"weights.{name}": values.numpy() for name, values in self.module.state_dict().items()}
        arrays |= {"trajectory.variance": self.mlpg.variance.astype(np.float32)} if self.mlpg else {}
        arrays |= {"mean": self.scaling.mean.astype(np.float32), "scale": self.scaling.scale.astype(np.float32)}
        settings = {
            "kind": "model",
            "family": self.family,
            "settings": dict(self.settings),
            "blocks": blocks,
            "rate": float(self.rate),
            "coding": self.coding,
            "about": dict(self.about),
        }
        write_model(path, arrays, settings)


def restore_network(
    arrays: Mapping[str, np.ndarray],
    settings: Mapping,
    path: str | Path,
    family: str,
    build: Callable[[Mapping, list[Layout], int], torch.nn.Module],
    shapes: Callable[[Mapping, list[Layout], int], Mapping[str, tuple[int, ...]]],
) -> Network:
    """A network from what :meth:`Network.save` wrote.

    Parameters
    ----------
    arrays, settings, path : content of a file, or of a part of it, and its path
    family : that it must be of
    build : (settings, layouts of the blocks, outputs) -> module without its weights
    shapes : of the same -> shape of each weight of that module by name, found without making it

    Raises
    ------
    StorageError
        As :func:`visualspeech.storage.models.check_model`, or the weights do not fit the settings.
    """
    check_model(arrays, settings, path, f"model of the family {family}", ["model"], LAYOUT, family)
    blocks = unpack(arrays, settings["blocks"], path)
    weights = {name: torch.tensor(values) for name, values in part_of(arrays, "weights").items()}
    made = settings["settings"], [block.layout for block in blocks.values()], len(arrays["mean"])
    try:
        if not blocks:
            raise ValueError("there is no input block")
        wanted, found = shapes(*made), {name: tuple(values.shape) for name, values in weights.items()}
        # Before the module is made: settings could ask for one that no memory holds.
        if wanted != found or any(values.dtype != torch.float32 for values in weights.values()):
            differ = sorted(name for name in {*wanted, *found} if wanted.get(name) != found.get(name))
            raise ValueError(f"of the weights, {', '.join(differ[:3]) or 'the types'} differ")
        module = build(*made)
        module.load_state_dict(weights)
    except (RuntimeError, TypeError, ValueError, SettingError) as error:
        raise DamagedFile(
            path,
            "its weights do not fit its settings; another version of this library wrote it, or it is damaged "
            f"({error})",
        ) from error
    return Network(
        family=family,
        settings=settings["settings"],
        module=module.eval(),
        scaling=Scaling(arrays["mean"], arrays["scale"]),
        blocks=blocks,
        rate=settings["rate"],
        coding=settings["coding"],
        about=settings["about"],
        mlpg=_mlpg(path, arrays, settings),
    )


def _mlpg(path: str | Path, arrays: Mapping[str, np.ndarray], settings: Mapping) -> Mlpg | None:
    """The generation of trajectories that a network's settings ask for; None for none."""
    own = settings["settings"]
    given = {one.name: own[one.name] for one in fields(TrajectorySettings) if one.name in own}
    chosen, variance = restored(TrajectorySettings, given, path), arrays.get("trajectory.variance")
    if (chosen.trajectory == "none") != (variance is None) or len(part_of(arrays, "trajectory")) > 1:
        raise DamagedFile(path, "its settings and the variances of a trajectory do not fit each other")
    if variance is None:
        return None
    if len(variance) % len(WINDOWS):
        raise DamagedFile(path, f"its {len(variance)} outputs are no static, delta and delta-delta parameters")
    check_generation(path, variance[None], step_of(chosen.delta_step, settings["rate"]))
    return Mlpg(variance, chosen.delta_step)


LAYOUT = FileLayout(
    {
        "mean": Array("f", ("N",), -1e9, 1e9),
        "scale": Array("f", ("N",), -1e9, 1e9),
        "weights.*": Array("f", None, -1e9, 1e9),
        "trajectory.*": Array("f", ("N",), 1e-15),
        **BLOCK_ARRAYS,
    },
    {
        "settings": {"type": "object"},
        "blocks": BLOCKS,
        "rate": RATE,
        "coding": TEXT,
        "about": {"type": "object"},
    },
)
