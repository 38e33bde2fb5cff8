"""25 MFCC, log F0 and energy of the sound by Praat, normalised per speaker (Sadoughi 2017 without eGeMAPS)."""

from dataclasses import dataclass
from typing import ClassVar

from visualspeech.features.speech_block import SpeechBlock, stored
from visualspeech.speech.speech_features import PRAAT_NAMES
from visualspeech.storage.layouts import FileLayout


@dataclass(frozen=True, eq=False)
class Speech27(SpeechBlock):
    """The 27 features that need no optional package."""

    kind: ClassVar[str] = "speech27"
    descriptors: ClassVar[bool] = False
    stored: ClassVar[FileLayout] = stored(len(PRAAT_NAMES))


BLOCK = Speech27
