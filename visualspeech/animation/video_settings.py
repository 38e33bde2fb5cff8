"""Settings of videos of test utterances (:mod:`visualspeech.animation.video`)."""

from dataclasses import dataclass

from visualspeech.animation.rendering import RenderSettings
from visualspeech.fields import Settings, setting


@dataclass(frozen=True)
class VideoSettings(Settings):
    """Videos of test utterances."""

    section = "videos"
    label: bool = setting(True, "Write a small label, synthetic, into every synthetic frame.")
    rendering: RenderSettings = setting(
        RenderSettings(), "Blending of the synthetic lower face into the recorded frame."
    )
