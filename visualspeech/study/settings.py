"""Settings of a viewing test, as a file in ``config/studies`` holds them."""

from dataclasses import dataclass

from visualspeech.errors import SettingError
from visualspeech.fields import Settings, setting, setting_error
from visualspeech.study.layouts import PREFERENCE, RATING

_LINE = r"[^\r\n]*"
#: A condition that is no model: the recorded face.
RECORDED = "recorded"
QUESTIONS = {
    PREFERENCE: {"preference": "Which of the two faces speaks more naturally?"},
    RATING: {"overall": "How natural is this face?"},
}
INTRODUCTION = (
    "You will see short videos of a talking face and be asked about each of them. Some or all of the faces were made "
    "by a computer.\n\n"
    "You need sound. Please take part in a quiet place, and alone."
)
CONSENT = (
    "Taking part is voluntary. You can stop at any time by closing the page, without giving a reason.\n\n"
    "Your answers are stored under a random code, with the time at which they were given. Your name, your address on "
    "the network and your browser are not stored, and there are no cookies. This browser remembers the code until you "
    "have finished, so that you can go on after an interruption."
)


@dataclass(frozen=True)
class StudySettings(Settings):
    """A viewing test: what is shown, and what is asked."""

    section = "studies"
    kind: str = setting(
        PREFERENCE,
        "Kind of test: preference, two conditions side by side; rating, one video at a time on a scale.",
        choices=(PREFERENCE, RATING),
    )
    title: str = setting("Talking faces", "Title of the pages.", min_length=1, max_length=200, pattern=_LINE)
    introduction: str = setting(
        "", "First page; blank lines divide paragraphs. Empty: a general text.", max_length=10_000
    )
    consent: str = setting(
        "", "What participants agree to on the first page. Empty: a general text.", max_length=20_000
    )
    questions: dict[str, str] = setting(
        {},
        "Name -> text of each question; one of a preference test. Empty: a question on naturalness.",
        item={
            "type": "object",
            "maxProperties": 20,
            "propertyNames": {
                "type": "string",
                "pattern": "^[a-z][a-z0-9_]{0,31}\\Z",
                "description": "At most 32 small letters, digits and _, a letter first.",
            },
            "additionalProperties": {
                "type": "string",
                "minLength": 1,
                "maxLength": 500,
                "description": "What participants read.",
            },
        },
    )
    forced: bool = setting(False, "Leave out the answer `no difference` of a preference test.")
    minimum: int = setting(1, "Lowest value of the scale of a rating test.", minimum=0, maximum=1)
    maximum: int = setting(10, "Highest value of the scale of a rating test.", minimum=2, maximum=20)
    lowest: str = setting("not natural at all", "What the lowest value means.", max_length=100, pattern=_LINE)
    highest: str = setting("very natural", "What the highest value means.", max_length=100, pattern=_LINE)
    utterances: int = setting(10, "Number of test utterances, drawn with the run's seed.", minimum=1, maximum=1000)
    practice: bool = setting(True, "Show one video first whose answer does not count, of another utterance.")
    attention: int = setting(
        0, "Number of attention items: videos that ask in writing for a certain answer.", minimum=0, maximum=20
    )
    sound_check: bool = setting(True, "Ask for a spoken word before the first video.")
    loudness: float = setting(
        -23.0,
        "Loudness of every stimulus in LUFS (EBU R 128); lower where one would be clipped.",
        minimum=-50,
        maximum=-5,
    )
    label: bool = setting(
        True, "Write a small label that says synthetic into every frame; never where `recorded` is a condition."
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.questions:
            object.__setattr__(self, "questions", dict(QUESTIONS[self.kind]))
        if self.kind == PREFERENCE and len(self.questions) != 1:
            raise setting_error(type(self), "questions", dict(self.questions), "one question in a preference test")
        if self.forced and self.kind == RATING:
            raise setting_error(type(self), "forced", True, "left out in a rating test")


def check_conditions(kind: str, conditions, where: str) -> None:
    """Check what a study compares: two conditions of a preference test, two to twenty of a rating test.

    Raises
    ------
    SettingError
        The number is wrong, or two are the same.
    """
    if kind == PREFERENCE and len(conditions) != 2:
        raise SettingError(
            f"`{where}.conditions` must name two conditions: a preference test shows two faces side by side. Write one "
            "study for each pair, or `kind: rating`."
        )
    if len(set(conditions)) < len(conditions):
        raise SettingError(f"`{where}.conditions` names one condition twice; leave one out.")
