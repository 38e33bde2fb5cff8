"""A trained network of any family: what prediction needs and nothing else, in one safetensors file."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path

import numpy as np
import torch

from visualspeech.errors import DamagedFile, SettingError
from visualspeech.features.blocks.base import Block
from visualspeech.features.streams import Layout, Stream, joined
from visualspeech.fields import restored
from visualspeech.models.batches import Batch, Scaling
from visualspeech.models.block_states import BLOCK_ARRAYS, BLOCKS, pack, unpack
from visualspeech.models.rows import MAX_WINDOW
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
    windows : seconds before and after a frame that it reads too, by input block
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
    windows: Mapping[str, float] = field(default_factory=dict)

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
        settings |= {"windows": dict(self.windows)} if self.windows else {}
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
    layout = WINDOWED if "windows" in settings else LAYOUT
    check_model(arrays, settings, path, f"model of the family {family}", ["model"], layout, family)
    windows = settings.get("windows", {})
    blocks = unpack(arrays, settings["blocks"], path)
    weights = {name: torch.tensor(values) for name, values in part_of(arrays, "weights").items()}
    try:
        if not blocks or not set(windows) <= set(blocks):
            raise ValueError(f"there is no input block{' of a window' * bool(blocks)}")
        made = settings["settings"], layouts_of(blocks, windows, settings["rate"]), len(arrays["mean"])
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
        windows=windows,
        mlpg=_mlpg(path, arrays, settings),
    )


def layouts_of(blocks: Mapping[str, Block], windows: Mapping[str, float], rate: float) -> list[Layout]:
    """Columns of input streams with their windows in frames, at least one where there is a window.

    Parameters
    ----------
    windows : seconds before and after a frame by block; none for a block that it lacks
    rate : frame rate in Hz

    Raises
    ------
    SettingError
        A block has rows of segments, which a network cannot read.
    """
    for name, block in blocks.items():
        if block.layout.segmental:
            raise SettingError(f"`reads` names {name}, which has a row per segment; a network reads rows of frames.")
    return [
        replace(block.layout, window=max(round(windows[name] * rate), 1)) if name in windows else block.layout
        for name, block in blocks.items()
    ]


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
#: Of a network that reads windows.
WINDOWED = FileLayout(
    LAYOUT.arrays,
    {
        **LAYOUT.plain,
        "windows": {
            "type": "object",
            "minProperties": 1,
            "maxProperties": 100,
            "additionalProperties": {"type": "number", "exclusiveMinimum": 0, "maximum": MAX_WINDOW},
        },
    },
)
