"""Settings of the alignment: where it comes from, how its phones are read, and forced alignment."""

from dataclasses import dataclass

from visualspeech.fields import Settings, setting, setting_error
from visualspeech.speech.phone_sets import PRESETS

#: Where an alignment comes from.
RECOGNISER, TEXTGRID, CTM = SOURCES = ("recogniser", "textgrid", "ctm")
_PATH = {"max_length": 1000, "pattern": r"[^\r\n]*"}


@dataclass(frozen=True)
class AlignmentSettings(Settings):
    """Where words and phones with their times come from; forced alignment, and when a transcript is rejected.

    The settings from ``speech_threshold`` on are those of forced alignment.

    A pause that is too short is the closure of the stop after it, or belongs to the word before. Words that are
    squeezed in beside noise consist of phones of minimum duration.
    """

    section = "alignment"
    source: str = setting(
        RECOGNISER,
        "Where words and phones with their times come from: forced alignment of the transcripts (recogniser), TextGrid "
        "files of the Montreal Forced Aligner or Praat, or CTM files.",
        choices=SOURCES,
    )
    folder: str = setting(
        "",
        "Folder of the TextGrid or CTM files, or one CTM file of phones; relative to the root of the corpus, or else "
        "to the working folder. Empty: beside the recordings.",
        **_PATH,
    )
    word_tier: str = setting(
        "words",
        "Name of the tier of words, also in `speaker - words`; of CTM files, what the name of those of words contains.",
        min_length=1,
        max_length=200,
    )
    phone_tier: str = setting(
        "phones",
        "Name of the tier of phones, also in `speaker - phones`; of CTM files, what the name of those of phones "
        "contains.",
        min_length=1,
        max_length=200,
    )
    phones: str = setting(
        "arpabet",
        "Phone set of the files and of `dictionary`: ARPAbet with or without stress (arpabet), IPA as in the English "
        "dictionaries of the Montreal Forced Aligner (ipa), any phones, which stay as they are (as_is), or the path of "
        "a table (.tsv, .csv, .yaml) that gives each label as phones of ARPAbet; relative as `folder`.",
        min_length=1,
        **_PATH,
    )
    states: str = setting(
        "thirds",
        "The three states of each phone of TextGrid and CTM files: its thirds, re-estimated from the sound by the "
        "recogniser (recognised), or read from the tier `states` of TextGrids that this project exported (tier).",
        choices=("thirds", "recognised", "tier"),
    )
    dictionary: str = setting(
        "",
        "Pronunciation dictionary in the format of MFA or CMU, whose words come before those of the built-in one; used "
        "in forced alignment and by the speaker. Relative as `folder`.",
        **_PATH,
    )
    speech_threshold: float = setting(
        0.3,
        "Loudness from which a frame counts as speech, as a share of the range from quiet to loud frames of the "
        "utterance.",
        minimum=0,
        maximum=1,
    )
    speech_margin: float = setting(
        0.1, "Time kept before and after the speech for the decoder, in seconds.", minimum=0, maximum=60
    )
    padding: float = setting(
        0.2, "Duration of the quiet noise added before and after the sound, in seconds.", minimum=0, maximum=5
    )
    padding_noise: float = setting(
        5.0, "Root-mean-square amplitude of the padding noise, in 16-bit steps.", minimum=0, maximum=1000
    )
    pause_probability: float = setting(0.05, "Probability of a pause between two words.", minimum=0, maximum=1)
    min_pause: float = setting(
        0.1,
        "Minimum duration of a pause between words in seconds; a shorter one becomes part of a neighbouring word.",
        minimum=0,
        maximum=60,
    )
    max_mismatch: float = setting(
        40.0,
        "An utterance is rejected if unconstrained phone recognition scores better than its transcript by more than "
        "this (log score of the decoder per frame of speech).",
        above=0,
        maximum=1_000_000,
    )
    max_word_mismatch: float = setting(
        110.0,
        "An utterance is rejected if the same difference exceeds this in one of its words (log score of the decoder "
        "per frame).",
        above=0,
        maximum=1_000_000,
    )
    word_mismatch_threshold: float = setting(
        45.0,
        "A word in which the same difference exceeds this counts as not said (log score of the decoder per frame).",
        above=0,
        maximum=1_000_000,
    )
    rejected_word_share: float = setting(
        0.25,
        "Share of the words, at least two of them, that count as not said, from which on an utterance is rejected.",
        above=0,
        maximum=1,
    )
    max_short_phone_share: float = setting(
        0.55,
        "An utterance is rejected if a larger share of its phones has the minimum duration of three frames (30 ms).",
        above=0,
        maximum=1,
    )

    def __post_init__(self) -> None:
        """Check each field, then what does not go together.

        Raises
        ------
        SettingError
            As :class:`Settings`; or a setting of files is given without files, or phones that are no ARPAbet are asked
            for where the recogniser or the voice must know them.
        """
        super().__post_init__()
        cls = type(self)
        if self.folder and self.source == RECOGNISER:
            raise setting_error(cls, "folder", self.folder, "empty, or `source` be textgrid or ctm")
        if self.states == "tier" and self.source != TEXTGRID:
            raise setting_error(cls, "states", self.states, "thirds or recognised, or `source` be textgrid")
        if self.phones == PRESETS[-1]:
            if self.source == RECOGNISER:
                raise setting_error(cls, "phones", self.phones, "another; the recogniser knows ARPAbet alone")
            if self.states == "recognised":
                raise setting_error(
                    cls, "states", self.states, "thirds with `phones: as_is`; the recogniser knows ARPAbet alone"
                )
            if self.dictionary:
                raise setting_error(
                    cls, "dictionary", self.dictionary, "empty with `phones: as_is`; the voice knows ARPAbet alone"
                )
