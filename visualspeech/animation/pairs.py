"""Two talking heads of one sentence side by side, for a preference test: nothing tells which model made which."""

from collections.abc import Sequence
from itertools import tee
from pathlib import Path

import numpy as np

from visualspeech.animation.video import (
    AUDIO_RATE,
    Panel,
    Recording,
    Speaker,
    VideoSettings,
    side_by_side,
    synthetic_frames,
    video_metadata,
)
from visualspeech.corpora.records import Utterance
from visualspeech.features.resampling import resample
from visualspeech.media import probe, read_audio, read_frames, write_video

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
    """Write the video of one pair: A on the left, B on the right, the original speech; frames one at a time.

    Parameters
    ----------
    number : of the pair, the only name that the file has for it
    appearances : of A and of B, each the parameters v (frames, N) and their frame rate in Hz
    corpus, consent : for the metadata, which say that the video is synthetic and withhold the models

    Raises
    ------
    DataError
        Streams of this utterance do not fit each other.
    RejectedUtterance
        The recording cannot be read.
    """
    settings = settings or VideoSettings()
    rate = probe(utterance.media).rate
    length = len(recording.landmarks)
    sources = tee(read_frames(utterance.media, utterance.start, utterance.end), len(appearances))
    panels = [
        Panel(
            title, synthetic_frames(source, resample(values, own, rate, length), recording, speaker, settings.rendering)
        )
        for title, source, (values, own) in zip("AB", sources, appearances, strict=True)
    ]
    sound = read_audio(utterance.media, AUDIO_RATE, utterance.start, utterance.end)
    metadata = video_metadata(f"Pair {number}", corpus, WITHHELD, consent)
    write_video(path, side_by_side(panels, settings.label), rate, sound, AUDIO_RATE, metadata)
