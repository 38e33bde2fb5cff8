"""Settings and sizes of networks that predict the regions of a face jointly or separately; without torch, for planning.

Joint-1, Joint-2, Separate-1 and Separate-2 of Sadoughi and Busso (2017), Fig. 3 and 4, are ``layers`` 1 or 2 with
``shared`` 2 or 0.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

from visualspeech.features.streams import Layout
from visualspeech.fields import setting, setting_error
from visualspeech.models.trajectory.settings import TrajectorySettings

#: Layers that the paper's joint networks share: the feed-forward layer and the first BLSTM layer.
SHARED = 2
#: BLSTM layers at most.
MAX_LAYERS = 4


@dataclass(frozen=True)
class JointSettings(TrajectorySettings):
    """Hidden layers of a network with one linear output layer per region of the face."""

    section: ClassVar[str] = "models"

    nodes: int = setting(
        128,
        "Width of the feed-forward layer, and of each direction of a BLSTM layer, for example 512.",
        minimum=1,
        maximum=4096,
    )
    layers: int = setting(1, "BLSTM layers above the feed-forward layer, for example 2.", minimum=1, maximum=MAX_LAYERS)
    shared: int = setting(
        SHARED,
        "Hidden layers, from the input up, that all regions of the face share; the feed-forward layer is the first. 2: "
        "Joint-1 and Joint-2 of Sadoughi and Busso (2017); 0: a network per region, trained by itself (Separate).",
        minimum=0,
        maximum=MAX_LAYERS + 1,
    )
    initialisation: str = setting(
        "glorot",
        "Initial weights: glorot (uniform, Glorot and Bengio 2010; biases 0, those of forget gates 1, as Keras), torch "
        "(uniform by layer width).",
        choices=("glorot", "torch"),
    )
    learning_rates: tuple[float, ...] = setting(
        (),
        "Learning rates of a search: a network is trained with each in place of `training.learning_rate`, and the one "
        "with the lowest validation error is kept. Empty: no search.",
        item={"description": "Learning rate.", "above": 0, "maximum": 1},
        unique=True,
        max_items=10,
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.shared > self.layers + 1:
            rule = f"at most {self.layers + 1} with `layers: {self.layers}`"
            raise setting_error(type(self), "shared", self.shared, rule)

    @property
    def separate(self) -> bool:
        """Whether the regions have nothing in common."""
        return not self.shared


def cell_name(settings: Mapping) -> str:
    """Name of a row, for example Joint-2-128; of a number of shared layers that the paper has not, with it."""
    kind = "Joint" if settings["shared"] else "Separate"
    other = "" if settings["shared"] in (0, SHARED) else f"-shared{settings['shared']}"
    return f"{kind}-{settings['layers']}-{settings['nodes']}{other}"


def parameter_count(settings: JointSettings, layouts: Sequence[Layout], regions: Mapping[str, Sequence[int]]) -> int:
    """Number of weights and biases of a network, without making it.

    Parameters
    ----------
    layouts : columns and windows of its inputs
    regions : columns of the coding's parameters by region
    """
    nodes, width, total = settings.nodes, sum(layout.width for layout in layouts), 0
    kinds = 3 if settings.trajectory == "mlpg" else 1
    for number in range(settings.layers + 1):
        copies = 1 if number < settings.shared else len(regions)
        # Four gates in two directions, each with weights of the layer below and of the layer itself, and a bias.
        total += copies * (8 * nodes * (width + nodes + 1) if number else nodes * (width + 1))
        width = 2 * nodes if number else nodes
    return total + kinds * sum(len(columns) * (width + 1) for columns in regions.values())


def check_regions(regions: Mapping[str, Sequence[int]], outputs: int) -> None:
    """Check that every output is in one region.

    Raises
    ------
    ValueError
        It is not, or the regions are no lists of columns by name.
    """
    if not isinstance(regions, Mapping) or not all(isinstance(one, list | tuple) for one in regions.values()):
        raise ValueError("the regions are no lists of columns by name")
    columns = [column for one in regions.values() for column in one]
    if not all(type(column) is int for column in columns) or not all(map(len, regions.values())):
        raise ValueError("a region has no columns, or they are no whole numbers")
    if len(columns) != outputs or sorted(columns) != list(range(outputs)):
        raise ValueError(f"the regions do not hold each of {outputs} outputs once")
