"""Videos for a preference test: two talking heads of one sentence side by side, without the names of the models."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from visualspeech.animation.video import Recording, Speaker, video_metadata, write_panels
from visualspeech.animation.video_settings import VideoSettings
from visualspeech.corpora.findings import needed
from visualspeech.corpora.records import Utterance

WITHHELD = "withheld for a preference test"


def write_pair(
    path: str | Path,
    number: int,
    utterance: Utterance,
    recording: Recording,
    appearances: Sequence[tuple[np.ndarray, float]],
    speaker: Speaker,
    corpus: str,
    consent: str = "",
    settings: VideoSettings | None = None,
) -> None:
    """Write the video of one pair with the original speech: A on the left, B on the right.

    Parameters
    ----------
    number : of the pair, its only name in the metadata
    appearances : of A and B, each the parameters v (frames, N) and their frame rate in Hz
    corpus, consent : for the metadata, which mark the video as synthetic and withhold the models

    Raises
    ------
    DataError
        Streams of this utterance do not fit each other.
    CorpusError
        The recording cannot be read; a study cannot do without the pair.
    """
    metadata = video_metadata(f"Pair {number}", corpus, WITHHELD, consent)
    titled = dict(zip("AB", appearances, strict=True))
    with needed(utterance):
        write_panels(path, utterance, recording, titled, speaker, metadata, settings)
