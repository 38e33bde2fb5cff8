"""Settings of the check of recordings (:mod:`visualspeech.corpora.check`)."""

from dataclasses import dataclass

from visualspeech.fields import Settings, setting


@dataclass(frozen=True)
class CheckSettings(Settings):
    """Limits of the check of recordings: ``min_`` and ``max_`` reject an utterance, ``warn_`` only reports it."""

    section = "check"
    min_seconds: float = setting(
        0.3, "Utterances shorter than this, in seconds, are rejected.", minimum=0, maximum=3600
    )
    min_rate: float = setting(
        10.0, "Recordings with fewer frames per second than this are rejected.", minimum=0, maximum=1000
    )
    warn_rate_below: float = setting(
        20.0, "Recordings with fewer frames per second than this are reported.", minimum=0, maximum=1000
    )
    warn_rate_above: float = setting(
        121.0, "Recordings with more frames per second than this are reported.", minimum=0, maximum=10_000
    )
    frame_interval_tolerance: float = setting(
        0.25,
        "Deviation of the time between two frames from its nominal value, as a share of it, above which it is "
        "reported.",
        minimum=0,
        maximum=100,
    )
    max_damaged_share: float = setting(
        0.1, "Utterances with a larger share of damaged frames than this are rejected.", minimum=0, maximum=1
    )
    max_missing_seconds: float = setting(
        0.3,
        "Utterances that end this much before their announced duration, in seconds, are rejected as truncated.",
        minimum=0,
        maximum=3600,
    )
    warn_length_difference: float = setting(
        0.2,
        "Difference between the durations of sound and video, in seconds, from which on it is reported.",
        minimum=0,
        maximum=3600,
    )
    max_length_difference: float = setting(
        1.0,
        "Difference between the durations of sound and video, in seconds, from which on an utterance is rejected.",
        minimum=0,
        maximum=3600,
    )
    static_threshold: float = setting(
        0.05,
        "A video whose frames never differ by more than this, in grey levels, is reported as a still image.",
        minimum=0,
        maximum=255,
    )
    min_level: float = setting(
        -60.0,
        "Sound whose loudest twentieth stays below this level, in dB relative to full scale, is rejected as silent.",
        minimum=-200,
        maximum=0,
    )
    min_level_range: float = setting(
        3.0,
        "Sound whose level varies by less than this, in dB, is rejected as free of speech.",
        minimum=0,
        maximum=200,
    )
    min_speech_seconds: float = setting(
        0.15,
        "Sound in which a voice activity detector hears less speech than this, in seconds, is rejected.",
        minimum=0,
        maximum=3600,
    )
    warn_clipped_share: float = setting(
        0.001, "Share of clipped samples from which on sound is reported as clipped.", minimum=0, maximum=1
    )
    warn_sample_rate_below: int = setting(
        16_000, "Sound with a lower sample rate than this, in Hz, is reported.", minimum=0, maximum=1_000_000
    )
