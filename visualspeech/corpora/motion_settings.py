"""Settings of the reading of motion capture (:mod:`visualspeech.corpora.motion`)."""

from dataclasses import dataclass

from visualspeech.fields import Settings, setting


@dataclass(frozen=True)
class MotionSettings(Settings):
    """Limits of motion capture: ``max_`` and ``min_`` reject an utterance."""

    section = "motion"
    max_gap: float = setting(
        0.25,
        "Longest gap of a marker that is interpolated, in seconds; utterances with a longer one, or with a longer "
        "pause between two rows, are rejected.",
        minimum=0,
        maximum=10,
    )
    max_length_difference: float = setting(
        0.5,
        "Difference between the durations of sound and motion capture, in seconds, above which an utterance is "
        "rejected.",
        minimum=0,
        maximum=3600,
    )
    min_seconds: float = setting(
        0.3,
        "Utterances with less motion capture than this, in seconds, are rejected.",
        minimum=0,
        maximum=3600,
    )
    min_rate: float = setting(
        10.0, "Motion capture with fewer frames per second than this is rejected.", minimum=1, maximum=1000
    )
    jitter_tolerance: float = setting(
        0.25,
        "Deviation of a row's time from a regular grid, as a share of a frame, above which the utterance is resampled.",
        minimum=0,
        maximum=1,
    )
