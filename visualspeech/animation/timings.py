"""Words, phones and visemes of what a talking head says, with their times in its video, as a JSON file."""

import json
from pathlib import Path

from visualspeech.speech.alignment import Alignment
from visualspeech.speech.phones import SILENCE
from visualspeech.speech.visemes import visemes_of
from visualspeech.storage.files import write_text

KIND, VERSION = "visualspeech timings", 1
DIGITS = 4  # of times: a tenth of a millisecond


class Timings:
    """Collects the times of the sentences or pieces of a performance, in their order."""

    def __init__(self) -> None:
        self._words: list[tuple[str, float, float]] = []
        self._phones: list[tuple[str, float, float]] = []

    def add(self, alignment: Alignment, begin: float, end: float) -> None:
        """Add the words and phones of one sentence.

        Parameters
        ----------
        alignment : of the sentence, from 0 s
        begin, end : of the sentence in the video, in seconds
        """
        for tier, kept in ((alignment.words, self._words), (alignment.phones, self._phones)):
            for one in tier:
                start, stop = begin + max(one.start, 0.0), min(begin + one.end, end)
                if one.label and stop > start:
                    kept.append((one.label, start, stop))

    def data(self, text: str, rate: float, frames: int) -> dict:
        """The times as plain data (docs/speaking.md).

        Parameters
        ----------
        text : what is said; empty if it is not known
        rate, frames : of the video, in Hz, and their number
        """
        return {
            "kind": KIND,
            "version": VERSION,
            "text": text,
            "rate": rate,
            "frames": frames,
            "seconds": round(frames / rate, DIGITS),
            "words": [_entry(*one) for one in self._words if one[0] != SILENCE],
            "phones": [_entry(*one) for one in _joined(self._phones)],
            "visemes": [{**_entry(*one), "mpeg4": one.number} for one in visemes_of(_joined(self._phones))],
        }

    def save(self, path: str | Path, text: str, rate: float, frames: int) -> None:
        """Write the times as JSON; parameters as :meth:`data`.

        Raises
        ------
        StorageError
            The file cannot be written.
        """
        write_text(path, json.dumps(self.data(text, rate, frames), indent=1, ensure_ascii=False) + "\n")


def _joined(phones: list[tuple[str, float, float]]) -> list[tuple[str, float, float]]:
    """The phones with pauses that follow each other, at the border of two sentences, joined."""
    joined: list[tuple[str, float, float]] = []
    for label, start, end in phones:
        if joined and label == SILENCE == joined[-1][0]:
            joined[-1] = (label, joined[-1][1], end)
        else:
            joined.append((label, start, end))
    return joined


def _entry(label: str, start: float, end: float) -> dict:
    return {"label": label, "start": round(start, DIGITS), "end": round(end, DIGITS)}
