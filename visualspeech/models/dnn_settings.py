"""Settings of feed-forward networks on windows of frames; without torch, for planning."""

from dataclasses import dataclass
from typing import ClassVar

from visualspeech.fields import setting
from visualspeech.models.trajectory.settings import TrajectorySettings

ACTIVATIONS = ("tanh", "sigmoid", "relu")


@dataclass(frozen=True)
class DnnSettings(TrajectorySettings):
    """Hidden layers of a feed-forward network."""

    section: ClassVar[str] = "models"

    layers: int = setting(3, "Hidden layers.", minimum=1, maximum=5)
    nodes: int = setting(512, "Width of a hidden layer.", minimum=1, maximum=4096)
    activation: str = setting("tanh", "Non-linearity of the hidden layers.", choices=ACTIVATIONS)
