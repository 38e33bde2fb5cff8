"""Settings of the look-up baselines, for planning."""

from dataclasses import dataclass
from typing import ClassVar

from visualspeech.fields import Settings, setting


@dataclass(frozen=True)
class LookupSettings(Settings):
    """A look-up from a frame's label to a mean over training frames."""

    section: ClassVar[str] = "models"

    context: str = setting(
        "triphone", "Classes that a mean is taken over: phone (and state), triphone (and state).",
        choices=("phone", "triphone"),
    )  # fmt: skip
    min_count: int = setting(
        3, "Training frames that a mean must rest on; below it the next coarser mean is used.", minimum=1, maximum=10**9
    )
