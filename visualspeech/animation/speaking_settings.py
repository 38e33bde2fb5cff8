"""Settings of the talking head (:mod:`visualspeech.animation.speaking`)."""

from dataclasses import dataclass

from visualspeech.animation.rendering import RenderSettings
from visualspeech.animation.walk import WalkSettings
from visualspeech.fields import Settings, setting


@dataclass(frozen=True)
class SpeakSettings(Settings):
    """Talking head that says any text."""

    section = "speak"
    label: bool = setting(True, "Write a small label, synthetic, into every frame.")
    walk: WalkSettings = setting(WalkSettings(), "Endless background from a few recorded seconds.")
    rendering: RenderSettings = setting(
        RenderSettings(), "Blending of the synthetic lower face into the recorded frame."
    )
