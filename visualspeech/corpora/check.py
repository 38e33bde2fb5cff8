"""The check of recordings before anything heavy runs: what a person has to know, with the file and the remedy.

Every recording is decoded once, to its end. What cannot be used is rejected; what is odd but usable is a warning.
"""

import hashlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from visualspeech.corpora.check_settings import CheckSettings
from visualspeech.corpora.findings import WARN, Finding, rejection
from visualspeech.corpora.records import Utterance
from visualspeech.errors import RejectedUtterance
from visualspeech.media import reading
from visualspeech.timing import frames_in

STAGE = "check"
RATE = 16_000  # Hz, of the sound that later stages hear


@dataclass(frozen=True)
class CheckedRecording:
    """Result of the check of one utterance.

    Parameters
    ----------
    samples : the sound, mono int16 at 16 kHz, shape (samples,); None where the utterance is rejected
    rejected : why it cannot be used, or None
    findings : all that was found, the rejection included
    digest : of the decoded pictures and sound; empty where nothing could be decoded
    frames : number of frames that :func:`visualspeech.media.reading.read_frames` yields
    """

    samples: np.ndarray | None
    rejected: RejectedUtterance | None
    findings: list[Finding] = field(default_factory=list)
    digest: str = ""
    frames: int = 0


def check_recording(
    utterance: Utterance, unknown_words: Callable[[str], list[str]], settings: CheckSettings
) -> CheckedRecording:
    """Check one utterance: transcript, pictures, sound, and whether they fit each other.

    Parameters
    ----------
    utterance : the recording and its transcript
    unknown_words : gives the words of a transcript that the pronunciation dictionary lacks
    settings : the limits

    Returns
    -------
    CheckedRecording; nothing is raised for a bad recording.
    """
    findings: list[Finding] = []
    digest, frames, samples, rejected = "", 0, None, None

    def warn(finding: str, remedy: str) -> None:
        findings.append(Finding(utterance.id, STAGE, WARN, utterance.media, finding, remedy))

    try:
        if not Path(utterance.media).is_file():
            raise RejectedUtterance("the file does not exist", "Bring it back, or take it out of the corpus's table.")
        _check_transcript(utterance)
        info = reading.probe(utterance.media)
        scan = reading.scan_video(utterance.media, utterance.start, utterance.end)
        frames = scan.frames
        sound = reading.read_audio(utterance.sound, RATE, utterance.start, utterance.end)
        digest = hashlib.sha256(scan.digest.encode() + sound.tobytes()).hexdigest()[:32]
        _check_end(utterance, scan, info, len(sound) / RATE, settings, warn)
        _check_pictures(scan, info, settings, warn)
        _check_sound(sound, info, settings, warn)
        unknown = unknown_words(utterance.transcript)
        if unknown:
            warn(
                f"not in the pronunciation dictionary: {', '.join(dict.fromkeys(unknown))}",
                "Look for spelling mistakes. Words that are right are pronounced by rule.",
            )
        samples = np.round(np.clip(sound, -1, 1) * 32767).astype(np.int16)
    except RejectedUtterance as error:
        rejected = error
        findings.insert(0, rejection(utterance.id, STAGE, utterance.media, error))
    return CheckedRecording(samples, rejected, findings, digest, frames)


def _check_transcript(utterance: Utterance) -> None:
    if any(character.isalnum() for character in utterance.transcript):
        return
    beside = Path(utterance.media).with_suffix(".txt")
    if utterance.transcript:
        raise RejectedUtterance(
            f"the transcript holds no word: {utterance.transcript!r}",
            f"Write what is said into {beside.name} beside the recording, or into the corpus's table.",
        )
    if beside.is_file():
        raise RejectedUtterance(f"the transcript {beside.name} is empty", "Write into it what is said.")
    raise RejectedUtterance(
        "no transcript",
        f"Write what is said into a file {beside.name} beside the recording, or into the column `transcript` of the "
        "corpus's table.",
    )


def _check_pictures(scan: reading.VideoScan, info: reading.MediaInfo, settings: CheckSettings, warn) -> None:
    seconds = scan.frames / info.rate
    if seconds < settings.min_seconds:
        raise RejectedUtterance(
            f"only {seconds:.2f} s of pictures ({scan.frames} frames)",
            "Record again, or mend start and end in the corpus's table.",
        )
    if info.rate < settings.min_rate:
        raise RejectedUtterance(
            f"{info.rate:.4g} frames per second are too few to see lips move", "Record at 25 frames per second or more."
        )
    if not settings.warn_rate_below <= info.rate <= settings.warn_rate_above:
        warn(
            f"an odd frame rate: {info.rate:.4g} per second", "Record at 25 to 60; features are resampled as they are."
        )
    steps = np.diff(scan.times) * info.rate
    uneven = int((np.abs(steps - 1) > settings.frame_interval_tolerance).sum())
    if uneven and uneven < 0.05 * len(steps):
        warn(
            f"{uneven} gap{'s' * (uneven > 1)} between pictures, the longest {steps.max() / info.rate * 1000:.0f} ms",
            "It is used, with pictures repeated there. Copy the recording again from its source if that is too much.",
        )
    elif uneven:
        warn(
            f"variable frame rate: {uneven} of {len(steps)} steps between pictures are uneven, the longest "
            f"{steps.max() / info.rate * 1000:.0f} ms at {info.rate:.4g} frames per second on average",
            "It is used, with pictures repeated or dropped at that constant rate. Better: switch variable rates off in "
            "the camera, or convert to a constant rate.",
        )
    damaged = len(scan.damaged)
    if damaged > settings.max_damaged_share * (len(scan.times) + damaged):
        raise RejectedUtterance(
            f"{damaged} of {len(scan.times)} pictures are damaged", "Copy the recording again from its source."
        )
    if damaged:
        places = ", ".join(f"{time:.2f}" for time in scan.damaged[:5])
        warn(
            f"{damaged} damaged picture{'s' * (damaged > 1)}, at {places}{' ...' * (damaged > 5)} s",
            "It is used, unless the face breaks up there. Copy the recording again from its source.",
        )
    if scan.change <= settings.static_threshold:
        warn("the picture never changes", "Give a video of the speaker, not a still picture with sound.")


def _check_end(
    utterance: Utterance,
    scan: reading.VideoScan,
    info: reading.MediaInfo,
    sound_seconds: float,
    settings: CheckSettings,
    warn,
) -> None:
    """Is all there that the header, the table and the other stream promise?"""
    seconds = scan.frames / info.rate
    if utterance.end:
        wanted = frames_in(utterance.end - utterance.start, info.rate)
        if scan.frames < wanted - settings.max_missing_seconds * info.rate:
            raise RejectedUtterance(
                f"the utterance is to end at {utterance.end:.2f} s, the recording ends at "
                f"{utterance.start + seconds:.2f} s",
                "Mend start and end in the corpus's table (they count seconds), or copy the recording again.",
            )
    else:
        if len(scan.damaged) and len(scan.times) and scan.damaged[-1] > scan.times[-1] - 1.5 / info.rate:
            raise RejectedUtterance(
                f"truncated: the file breaks off within a picture, {scan.times[-1]:.2f} s after its beginning",
                "Copy the recording again from its source.",
            )
        there = utterance.start + seconds
        # The video stream's own figure where it has one: sound may well go on after the pictures.
        for promised, found in (
            (info.video_duration, there),
            (info.duration, max(there, utterance.start + sound_seconds)),
        ):
            if promised - found > max(settings.max_missing_seconds, 2 / info.rate):
                raise RejectedUtterance(
                    f"truncated: its header announces {promised:.2f} s, but it breaks off after {found:.2f} s",
                    "Copy the recording again from its source.",
                )
    if not utterance.start and info.early_sound >= settings.warn_length_difference:
        warn(
            f"the pictures begin {info.early_sound:.2f} s after the sound, which is left out until then",
            "Check that no speech is lost; export the recording again with both streams whole.",
        )
    difference = sound_seconds - seconds
    if abs(difference) >= settings.warn_length_difference:
        said = f"sound and picture differ in length: {sound_seconds:.2f} s of sound, {seconds:.2f} s of picture"
        remedy = "Check that lips and sound are together; export the recording again with both streams whole."
        if abs(difference) >= settings.max_length_difference:
            raise RejectedUtterance(said, remedy)
        warn(said, remedy)


def _check_sound(sound: np.ndarray, info: reading.MediaInfo, settings: CheckSettings, warn) -> None:
    levels = frame_levels(sound)
    loud = np.percentile(levels, 95) if len(levels) else -np.inf
    if loud < settings.min_level:
        raise RejectedUtterance(
            "silent audio" if not sound.any() else f"silent audio (at most {loud:.0f} dB of full scale)",
            "Check the microphone and the audio track, and record again.",
        )
    spread = loud - np.percentile(levels, 10)
    voiced = speech_seconds(sound)
    if spread < settings.min_level_range or voiced < settings.min_speech_seconds:
        raise RejectedUtterance(
            f"audio without speech (its level varies by {spread:.0f} dB, {voiced:.2f} s sound like a voice)",
            "Check that the right audio track is in the file and that start and end fit.",
        )
    if info.audio_rate < settings.warn_sample_rate_below:
        warn(
            f"audio at {info.audio_rate / 1000:g} kHz",
            "It is used, but s, f and th can hardly be told apart. Record at 16 kHz or more.",
        )
    clipped = clipped_share(sound)
    if clipped >= settings.warn_clipped_share:
        warn(
            f"clipped audio ({clipped:.1%} of the samples cut off)",
            "It is used, but may be aligned badly. Record at a lower level.",
        )


def frame_levels(sound: np.ndarray) -> np.ndarray:
    """Level of each 20 ms of a sound at 16 kHz, in dB of full scale but not below -200, shape (samples // 320,)."""
    frames = sound[: len(sound) // 320 * 320].reshape(-1, 320).astype(np.float64)
    with np.errstate(divide="ignore"):
        return np.maximum(10 * np.log10((frames**2).mean(axis=1)), -200.0)


def clipped_share(sound: np.ndarray) -> float:
    """Share of samples that lie where a limit cut the sound off; below 0.0005 in sound speech.

    Two signs: samples within 3 % of the peak (a limit, as recorded), and a hill near the upper end of the histogram of
    the amplitudes, which falls steadily in speech (a limit, blurred by lossy coding): a window of a factor 1.22 that
    holds at least 0.2 % of the samples and 1.7 times as many as the window below it. Of 50 recordings of GRID none is
    taken for clipped; with 0.3 to 3 % of the samples cut off, 98 % to all of them are, before and after AAC coding.
    """
    size = np.abs(sound)
    peak = size.max(initial=0.0)
    if not peak:
        return 0.0
    at_peak = float((size >= 0.97 * peak).mean())
    width = 10
    borders = np.linspace(-80 * 0.02, 0.02, 82)
    counts, _ = np.histogram(np.log(np.maximum(size / peak, 1e-6)), borders)
    windows = np.convolve(counts, np.ones(width, int), "valid")
    above, below = windows[width:], windows[:-width]
    upper = borders[2 * width :] >= np.log(0.6)
    hills = above[upper & (above >= 0.002 * len(size)) & (above >= 1.7 * below)]
    return max(at_peak, float(hills.max(initial=0)) / len(size))


def speech_seconds(sound: np.ndarray) -> float:
    """Seconds in which WebRTC's voice activity detector, at its strictest, hears speech in a sound at 16 kHz."""
    from pocketsphinx import Vad

    detector = Vad(3, RATE, 0.03)
    size = detector.frame_bytes // 2
    peak = max(float(np.abs(sound).max(initial=0.0)), 1e-9)
    # The detector was made for speech at a telephone's level.
    samples = np.round(sound / peak * 16_000).astype("<i2")
    heard = sum(detector.is_speech(samples[at : at + size].tobytes()) for at in range(0, len(samples) - size + 1, size))
    return heard * size / RATE


def find_duplicates(digests: Mapping[str, str], utterances: Iterable[Utterance]) -> list[Finding]:
    """A rejection for each recording whose decoded content is that of one with an earlier id.

    A copy would be trained on and tested on, and make every table look better than it is.
    """
    first: dict[str, Utterance] = {}
    findings = []
    for utterance in sorted(utterances, key=lambda one: one.id):
        digest = digests.get(utterance.id, "")
        if digest and digest in first:
            other = first[digest]
            differs = "" if utterance.transcript == other.transcript else " with another transcript"
            error = RejectedUtterance(
                f"the same recording as {other.media} (utterance {other.id}){differs}",
                "Remove one of the two." if not differs else "Remove the one whose transcript is wrong.",
            )
            findings.append(rejection(utterance.id, STAGE, utterance.media, error))
        elif digest:
            first[digest] = utterance
    return findings


def write_digests(path, digests: Mapping[str, str]) -> None:
    """Write the digests of a shard's recordings as a table (id, digest), sorted by id."""
    import pandas

    from visualspeech.storage import write_table

    write_table(path, pandas.DataFrame(sorted(digests.items()), columns=["id", "digest"]))


def read_digests(paths: Iterable) -> dict[str, str]:
    """Read the digests of several shards: id -> digest."""
    from visualspeech.storage import read_table

    tables = [read_table(path, ("id", "digest")) for path in paths]
    return {name: digest for table in tables for name, digest in zip(table["id"], table["digest"], strict=True)}
