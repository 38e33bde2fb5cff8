"""The alignment of each utterance of a corpus: forced, read from files, or speech and pauses alone."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from difflib import SequenceMatcher

import numpy as np

from visualspeech.corpora.label_files import LabelFiles, LabelReader
from visualspeech.corpora.records import Utterance
from visualspeech.speech import transcript as transcripts
from visualspeech.speech.alignment_settings import RECOGNISER, AlignmentSettings
from visualspeech.speech.dictionary import lexicon_with
from visualspeech.speech.forced_alignment import Aligner
from visualspeech.speech.given import Assembled, Given, assembled
from visualspeech.speech.given_states import recognised_states
from visualspeech.speech.phone_sets import UNKNOWN_SOUND, PhoneSet
from visualspeech.speech.phones import SILENCE
from visualspeech.speech.recognition import RATE
from visualspeech.speech.segmentation import segmented

WARN_STATES = 0.2  # share of the phones of an utterance whose states are not recognised, from which on it is reported


@dataclass(frozen=True)
class AlignmentSources:
    """What alignment reads beside its settings and the sound.

    Parameters
    ----------
    phones : phone set of files and dictionary
    dictionary : path of a pronunciation dictionary; empty for none
    labels : the files of alignments; None where there are none
    """

    phones: PhoneSet = field(default_factory=PhoneSet)
    dictionary: str = ""
    labels: LabelFiles | None = None

    def plain(self) -> dict:
        """Plain data, of which :meth:`of` makes it again."""
        return {
            "phones": {"name": self.phones.name, "table": dict(self.phones.table)},
            "dictionary": self.dictionary,
            "labels": None if self.labels is None else self.labels.plain(),
        }

    @classmethod
    def of(cls, plain: Mapping) -> "AlignmentSources":
        """The inverse of :meth:`plain`."""
        labels = None if plain["labels"] is None else LabelFiles.of(plain["labels"])
        return cls(PhoneSet(**plain["phones"]), plain["dictionary"], labels)


def aligner(
    settings: AlignmentSettings, sources: AlignmentSources, text: bool = True
) -> Callable[[Utterance, np.ndarray], Assembled]:
    """The function that aligns utterances: of an utterance and its samples (n,) int16, mono, 16 kHz.

    It raises :class:`RejectedUtterance` where an utterance cannot be aligned.

    Parameters
    ----------
    text : whether it is known what is said; otherwise speech is told from pauses

    Raises
    ------
    SettingError, CorpusError
        The dictionary or a CTM file cannot be read.
    """
    if not text:
        return lambda utterance, samples: Assembled(segmented(samples))
    if settings.source == RECOGNISER:
        align = Aligner(settings, lexicon_with(sources.dictionary, sources.phones)).align
        return lambda utterance, samples: Assembled(align(samples, utterance.transcript))
    reader = LabelReader(sources.labels, settings)

    def from_files(utterance: Utterance, samples: np.ndarray) -> Assembled:
        given = reader.read(utterance)
        found = assembled(given, len(samples) / RATE, sources.phones, settings.states == "tier")
        alignment, warnings = found.alignment, list(found.warnings)
        if settings.states == "recognised":
            alignment, kept = recognised_states(alignment, samples, settings)
            spoken = sum(one.label != SILENCE for one in alignment.phones)
            if kept > WARN_STATES * spoken:
                warnings.append((
                    f"{given.file}: the recogniser does not find {kept} of {spoken} phones where the file has them; "
                    "their states are thirds",
                    "Check that the file belongs to this recording.",
                ))  # fmt: skip
        if difference := transcript_difference(given, utterance.transcript):
            warnings.append((f"{given.file}: {difference}", "The words of the file count. Correct one of the two."))
        return Assembled(alignment, tuple(warnings))

    return from_files


def transcript_difference(given: Given, transcript: str) -> str:
    """Where the words of a file differ from a transcript, in words; empty where they do not, or there is none."""
    if not transcript.strip():
        return ""
    of_file = [_plain(word) for one in given.words for word in one.label.lower().split()]
    of_file = [word for word in of_file if word and word not in ("sil", "sp", "eps")]
    known = frozenset(of_file)
    of_text = [_plain(word) for word in transcripts.normalise(transcript, known.__contains__)]
    first, second = (" ".join(words).replace("'", "").split() for words in (of_file, of_text))
    for kind, a, b, c, d in SequenceMatcher(None, first, second, autojunk=False).get_opcodes():
        if kind != "equal" and not _is_unknown(first[a:b], second[c:d]):
            shown = [" ".join(words[:4]) or "nothing" for words in (first[a:b], second[c:d])]
            return f"its words differ from the transcript: {shown[0]!r} where the transcript has {shown[1]!r}"
    return ""


def _is_unknown(words: list[str], others: list[str]) -> bool:
    """Whether the words of a file stand for any others: words that its aligner did not know."""
    return len(words) == len(others) and all(word == "unk" or f"<{word}>" in UNKNOWN_SOUND for word in words)


def _plain(word: str) -> str:
    return "".join(one for one in word if one.isalnum() or one in "'-").strip("-")
