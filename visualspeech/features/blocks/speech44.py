"""25 MFCC, log F0, energy and 17 descriptors of eGeMAPS, normalised per speaker (Sadoughi 2017, section 3.2).

Needs the package ``opensmile`` (``pip install -e '.[egemaps]'``), whose licence allows research only.
"""

from dataclasses import dataclass
from typing import ClassVar

from visualspeech.features.speech_block import SpeechBlock, stored
from visualspeech.speech import egemaps
from visualspeech.speech.speech_features import ALL_NAMES
from visualspeech.storage.layouts import FileLayout


@dataclass(frozen=True, eq=False)
class Speech44(SpeechBlock):
    """The 44 features of the paper."""

    kind: ClassVar[str] = "speech44"
    descriptors: ClassVar[bool] = True
    stored: ClassVar[FileLayout] = stored(len(ALL_NAMES))

    @classmethod
    def unavailable(cls) -> str:
        """Why the block cannot be computed here; empty if it can."""
        return egemaps.missing()


BLOCK = Speech44
