"""Forced alignment in one call, and the name of the recording in what is said about it."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from visualspeech.errors import RejectedUtterance
from visualspeech.speech import forced_alignment
from visualspeech.speech.alignment import Alignment
from visualspeech.speech.alignment_settings import AlignmentSettings
from visualspeech.speech.lexicon import Lexicon


@contextmanager
def named(recording) -> Iterator[None]:
    """Say which recording a :class:`RejectedUtterance` is about, and what to do, in its message."""
    try:
        yield
    except RejectedUtterance as error:
        where = f"{recording}: " if isinstance(recording, str | Path) else ""
        said = f"{where}{error.reason.rstrip('.')}. {error.remedy}".strip()
        raise RejectedUtterance(said, error.remedy) from error


def align(
    sound: str | Path | np.ndarray,
    transcript: str,
    *,
    lexicon: Lexicon | None = None,
    settings: AlignmentSettings | None = None,
) -> Alignment:
    """Words, phones and HMM states of a recording with their times: forced alignment with its transcript.

    Parameters
    ----------
    sound : path of a sound or video file, or samples (n,) at 16 kHz, mono: int16, or floating-point in [-1, 1]
    transcript : as written, in English
    lexicon : pronunciations; a lexicon that is passed to several calls is read once
    settings : pauses, and when a transcript is rejected

    Returns
    -------
    :class:`~visualspeech.Alignment` with the tiers ``words``, ``phones`` and ``states``, segments with ``label``,
    ``start`` and ``end`` in seconds; ``sil`` is a pause

    Raises
    ------
    RejectedUtterance
        The recording cannot be read, there is no speech, a word cannot be pronounced, or the transcript is not what is
        said.
    DataError
        The samples are of another type or shape, or out of range.
    """
    with named(sound):
        return forced_alignment.align(sound, transcript, lexicon, settings)
