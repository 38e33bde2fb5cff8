"""Settings of what is generated from a network's outputs; without torch, for planning."""

from dataclasses import dataclass
from typing import ClassVar

from visualspeech.fields import Settings, setting


@dataclass(frozen=True, kw_only=True)
class TrajectorySettings(Settings):
    """What a network's outputs stand for. Settings of a family of networks inherit these."""

    section: ClassVar[str] = "models"

    trajectory: str = setting(
        "none",
        "What follows the outputs: none (they are the parameters), mlpg (they are static, delta and delta-delta "
        "parameters, from which the most likely trajectory is generated).",
        choices=("none", "mlpg"),
    )
    trajectory_variance: str = setting(
        "errors",
        "How `trajectory: mlpg` weights the outputs, by their inverse variances: errors (of the outputs on training "
        "utterances), targets (of the training targets themselves, as Thangthai et al. 2016).",
        choices=("errors", "targets"),
    )
    delta_step: float = setting(
        0.04,
        "Time between the taps of the delta windows with `trajectory: mlpg`, in seconds; at least one frame.",
        minimum=0.0001,
        maximum=1,
    )
