"""Settings of stacks of feed-forward, BLSTM and convolutional layers; without torch, for planning."""

from dataclasses import dataclass
from typing import ClassVar

from visualspeech.fields import setting, setting_error
from visualspeech.models.trajectory.settings import TrajectorySettings

#: Hidden layers at most; each one is a job's memory and time.
MAX_LAYERS = 16


@dataclass(frozen=True)
class StackSettings(TrajectorySettings):
    """Hidden layers of a stack.

    Fan 2015 does not say what the width of a B layer counts; Sadoughi and Busso (2017) count directions.
    """

    section: ClassVar[str] = "models"

    letters: str = setting(
        "FBB",
        f"Hidden layers from the input up, one capital letter each, at most {MAX_LAYERS}: F feed-forward, B "
        "bidirectional LSTM, C gated dilated convolution; for example FBB.",
        pattern=f"[FBC]{{1,{MAX_LAYERS}}}",
    )
    nodes: int = setting(128, "Width of a hidden layer, for example 128.", minimum=1, maximum=4096)
    b_nodes: str = setting(
        "direction",
        "What the width of a B layer counts: the nodes of one direction, or of both directions of the layer.",
        choices=("direction", "layer"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.b_nodes == "layer" and "B" in self.letters and self.nodes % 2:
            rule = "even: with `b_nodes: layer` the two directions of a B layer share its nodes"
            raise setting_error(type(self), "nodes", self.nodes, f"{rule}; write {self.nodes + 1}")

    @property
    def direction_nodes(self) -> int:
        """Nodes of one direction of a B layer."""
        return self.nodes if self.b_nodes == "direction" else self.nodes // 2
