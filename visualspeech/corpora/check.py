"""The check of recordings before any expensive stage.

Every recording is decoded once, to its end. Unusable utterances are rejected; usable ones with a problem get a warning.
Each finding names the file and a remedy.
"""

import hashlib
import os
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from visualspeech.corpora.check_settings import CheckSettings
from visualspeech.corpora.findings import UNLISTED, WARN, Finding, attempt, rejection
from visualspeech.corpora.records import Utterance
from visualspeech.errors import RejectedUtterance
from visualspeech.media import reading
from visualspeech.provenance import file_digest
from visualspeech.timing import frames_in

STAGE = "check"
RATE = 16_000  # Hz, sample rate of the sound that later stages read


@dataclass(frozen=True)
class CheckedRecording:
    """Result of the check of one utterance.

    Parameters
    ----------
    samples : the sound, mono int16 at 16 kHz, shape (samples,); None if the utterance is rejected
    rejected : why the utterance cannot be used; None if it is accepted
    findings : all findings, including the rejection
    digest : of the decoded frames and sound; empty if they could not be decoded
    frames : number of frames that :func:`visualspeech.media.reading.read_frames` yields
    """

    samples: np.ndarray | None
    rejected: RejectedUtterance | None
    findings: list[Finding] = field(default_factory=list)
    digest: str = ""
    frames: int = 0


def check_recording(
    utterance: Utterance, unknown_words: Callable[[str], list[str]], settings: CheckSettings, text: bool = True
) -> CheckedRecording:
    """Check the transcript, video and sound of one utterance, and whether their durations match.

    Where the face was recorded as motion capture there is no video; its file is checked where it is read
    (:mod:`visualspeech.corpora.motion`).

    Parameters
    ----------
    utterance : the recording and its transcript
    unknown_words : returns the words of a transcript that the pronunciation dictionary does not list
    settings : the limits
    text : whether transcripts are needed: an utterance without one is then rejected, and unknown words are reported

    Returns
    -------
    CheckedRecording; a bad recording is reported in it and does not raise an error.
    """
    findings: list[Finding] = []
    digest, frames = "", 0

    def warn(finding: str, remedy: str) -> None:
        findings.append(Finding(utterance.id, STAGE, WARN, utterance.file, finding, remedy))

    def samples() -> np.ndarray:
        nonlocal digest, frames
        if utterance.problem:
            raise RejectedUtterance(utterance.problem, utterance.remedy)
        if utterance.warning:
            warn(utterance.warning, utterance.remedy)
        for path in filter(None, (utterance.media, utterance.motion, utterance.audio)):
            _check_exists(path, "" if path == utterance.file else f" {os.path.basename(path)}")
        if text:
            _check_transcript(utterance)
        if utterance.media:
            info = reading.probe(utterance.media)
            scan = reading.scan_video(utterance.media, utterance.start, utterance.end)
            frames, content, sound_rate = scan.frames, scan.digest, info.audio_rate
        else:
            content, sound_rate = file_digest(utterance.motion), reading.sound_rate(utterance.sound)
        sound = reading.read_audio(utterance.sound, RATE, utterance.start, utterance.end)
        digest = hashlib.sha256(content.encode() + sound.tobytes()).hexdigest()[:32]
        if utterance.media:
            _check_durations(utterance, scan, info, len(sound) / RATE, settings, warn)
            _check_frames(scan, info, settings, warn)
        elif len(sound) / RATE < settings.min_seconds:
            raise RejectedUtterance(f"only {len(sound) / RATE:.2f} s of sound", "Record again, or leave it out.")
        _check_sound(sound, sound_rate, settings, warn)
        unknown = unknown_words(utterance.transcript) if text else []
        if unknown:
            warn(
                f"{UNLISTED}{', '.join(dict.fromkeys(unknown))}",
                "Correct spelling mistakes. Other words are pronounced by letter-to-sound rules.",
            )
        return np.round(np.clip(sound, -1, 1) * 32767).astype(np.int16)

    found = attempt(utterance, STAGE, samples)
    return CheckedRecording(found.value, found.rejected, [*found.findings, *findings], digest, frames)


def _check_exists(media: str, name: str = "") -> None:
    if os.path.isfile(media):
        return
    if not os.path.lexists(media):
        raise RejectedUtterance(f"the file{name} does not exist", "Restore it, or remove it from the corpus's table.")
    what = "is a folder" if os.path.isdir(media) else "is no regular file, or a link to a file that does not exist"
    raise RejectedUtterance(f"the recording{name} {what}", "Restore it, or name the file that holds the recording.")


def _check_transcript(utterance: Utterance) -> None:
    if any(character.isalnum() for character in utterance.transcript):
        return
    beside = Path(utterance.file).with_suffix(".txt")
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


def _check_frames(scan: reading.VideoScan, info: reading.MediaInfo, settings: CheckSettings, warn) -> None:
    seconds = scan.frames / info.rate
    if seconds < settings.min_seconds:
        raise RejectedUtterance(
            f"only {seconds:.2f} s of video ({scan.frames} frames)",
            "Record again, or correct start and end in the corpus's table.",
        )
    if info.rate < settings.min_rate:
        raise RejectedUtterance(
            f"{info.rate:.4g} frames per second are too few for lip movement", "Record at 25 frames per second or more."
        )
    if not settings.warn_rate_below <= info.rate <= settings.warn_rate_above:
        warn(
            f"unusual frame rate: {info.rate:.4g} frames per second",
            "Record at 25 to 60 frames per second. The recording is used at its own rate.",
        )
    steps = np.diff(scan.times) * info.rate
    uneven = int((np.abs(steps - 1) > settings.frame_interval_tolerance).sum())
    if uneven and uneven < 0.05 * len(steps):
        warn(
            f"{uneven} gap{'s' * (uneven > 1)} between frames, the longest {steps.max() / info.rate * 1000:.0f} ms",
            "The recording is used; frames are repeated in the gaps. To avoid that, copy it again from its source.",
        )
    elif uneven:
        warn(
            f"variable frame rate: {uneven} of {len(steps)} frame intervals are uneven, the longest "
            f"{steps.max() / info.rate * 1000:.0f} ms at {info.rate:.4g} frames per second on average",
            "The recording is used at the average rate; frames are repeated or dropped. Better switch variable rates "
            "off in the camera, or convert the recording to a constant rate.",
        )
    damaged = len(scan.damaged)
    if damaged > settings.max_damaged_share * (len(scan.times) + damaged):
        raise RejectedUtterance(
            f"{damaged} of {len(scan.times) + damaged} frames are damaged", "Copy the recording again from its source."
        )
    if damaged:
        times = ", ".join(f"{time:.2f}" for time in scan.damaged[:5])
        warn(
            f"{damaged} damaged frame{'s' * (damaged > 1)}, at {times}{' ...' * (damaged > 5)} s",
            "The recording is used unless its landmarks fail there. Copy the recording again from its source.",
        )
    if scan.change <= settings.static_threshold:
        warn("the frames never change", "Give a video of the speaker, not a still image with sound.")


def _check_durations(
    utterance: Utterance,
    scan: reading.VideoScan,
    info: reading.MediaInfo,
    sound_seconds: float,
    settings: CheckSettings,
    warn,
) -> None:
    """Compare the duration of the video with the header, the corpus's table and the sound.

    Raises
    ------
    RejectedUtterance
        The recording is truncated, or video and sound differ too much in length.
    """
    seconds = scan.frames / info.rate
    if utterance.end:
        wanted = frames_in(utterance.end - utterance.start, info.rate)
        if scan.frames < wanted - settings.max_missing_seconds * info.rate:
            raise RejectedUtterance(
                f"the utterance should end at {utterance.end:.2f} s, but the recording ends at "
                f"{utterance.start + seconds:.2f} s",
                "Correct start and end in the corpus's table (in seconds), or copy the recording again.",
            )
    else:
        damaged_end = len(scan.damaged) and len(scan.times) and scan.damaged[-1] > scan.times[-1] - 1.5 / info.rate
        if damaged_end and not _reaches_its_end(scan, info):
            raise RejectedUtterance(
                f"truncated, or damaged at its end: the last frame, {scan.damaged[-1]:.2f} s after the first, is "
                "incomplete",
                "Copy the recording again from its source.",
            )
        video_end = utterance.start + seconds
        # The sound may continue after the last frame, so the video stream is compared with its own duration.
        for announced, found in (
            (info.video_duration, video_end),
            (info.duration, max(video_end, utterance.start + sound_seconds)),
        ):
            if announced - found > max(settings.max_missing_seconds, 2 / info.rate):
                raise RejectedUtterance(
                    f"truncated: its header announces {announced:.2f} s, but it breaks off after {found:.2f} s",
                    "Copy the recording again from its source.",
                )
    if not utterance.start and info.early_sound >= settings.warn_length_difference:
        warn(
            f"the video begins {info.early_sound:.2f} s after the sound; the sound before it is left out",
            "Check that no speech is lost; export the recording again with both streams complete.",
        )
    difference = sound_seconds - seconds
    if abs(difference) >= settings.warn_length_difference:
        finding = f"sound and video differ in length: {sound_seconds:.2f} s of sound, {seconds:.2f} s of video"
        remedy = "Check that lips and sound are synchronous; export the recording again with both streams complete."
        if abs(difference) >= settings.max_length_difference:
            raise RejectedUtterance(finding, remedy)
        warn(finding, remedy)


def _reaches_its_end(scan: reading.VideoScan, info: reading.MediaInfo) -> bool:
    """Whether the last frame, damaged or not, is the last one that the header announces."""
    announced = info.video_duration or info.duration
    return info.announced and 0 < announced <= max(scan.times[-1], scan.damaged[-1]) + 1.5 / info.rate


def _check_sound(sound: np.ndarray, sound_rate: int, settings: CheckSettings, warn) -> None:
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
            f"audio without speech (its level varies by {spread:.0f} dB, {voiced:.2f} s of speech are detected)",
            "Check that the file has the right audio track, and that start and end are correct.",
        )
    if 0 < sound_rate < settings.warn_sample_rate_below:
        warn(
            f"audio at {sound_rate / 1000:g} kHz",
            "The recording is used, but s, f and th are hard to distinguish. Record at 16 kHz or more.",
        )
    clipped = clipped_share(sound)
    if clipped >= settings.warn_clipped_share:
        warn(
            f"clipped audio ({clipped:.1%} of the samples)",
            "The recording is used, but its alignment may be poor. Record at a lower level.",
        )


def frame_levels(sound: np.ndarray) -> np.ndarray:
    """Level of each 20 ms of a sound at 16 kHz in dB relative to full scale, at least -200, shape (samples // 320,)."""
    frames = sound[: len(sound) // 320 * 320].reshape(-1, 320).astype(np.float64)
    with np.errstate(divide="ignore"):
        return np.maximum(10 * np.log10((frames**2).mean(axis=1)), -200.0)


def clipped_share(sound: np.ndarray) -> float:
    """Share of clipped samples; below 0.0005 in unclipped speech.

    There are two signs of clipping: samples within 3 % of the peak, and, after lossy coding, a hill near the upper end
    of the histogram of amplitudes, which falls steadily in speech. A hill is a window of a factor 1.22 that holds at
    least 0.2 % of the samples and 1.7 times as many as the window below it. None of 50 recordings of GRID is classified
    as clipped; with 0.3 to 3 % of the samples clipped, 98 to 100 % of them are, before and after AAC coding.
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
    """Seconds of speech in a sound at 16 kHz, by WebRTC's voice activity detector in its strictest mode."""
    from pocketsphinx import Vad

    detector = Vad(3, RATE, 0.03)
    size = detector.frame_bytes // 2
    peak = max(float(np.abs(sound).max(initial=0.0)), 1e-9)
    # The detector expects speech at the level of a telephone.
    samples = np.round(sound / peak * 16_000).astype("<i2")
    heard = sum(detector.is_speech(samples[at : at + size].tobytes()) for at in range(0, len(samples) - size + 1, size))
    return heard * size / RATE


def find_duplicates(digests: Mapping[str, str], utterances: Iterable[Utterance]) -> list[Finding]:
    """A rejection for each recording with the same decoded content as one with an earlier id.

    Otherwise a recording could be in both the training and the test set, and test figures would be too good.

    Parameters
    ----------
    digests : utterance id -> :attr:`CheckedRecording.digest`
    utterances : all utterances of the corpus
    """
    first: dict[str, Utterance] = {}
    findings = []
    for utterance in sorted(utterances, key=lambda one: one.id):
        digest = digests.get(utterance.id, "")
        if digest and digest in first:
            other = first[digest]
            differs = "" if utterance.transcript == other.transcript else " with another transcript"
            error = RejectedUtterance(
                f"the same recording as {other.file} (utterance {other.id}){differs}",
                "Remove one of the two." if not differs else "Remove the one whose transcript is wrong.",
            )
            findings.append(rejection(utterance.id, STAGE, utterance.file, error))
        elif digest:
            first[digest] = utterance
    return findings


def write_digests(path, digests: Mapping[str, str]) -> None:
    """Write the digests of a shard's recordings as a table (id, digest), sorted by id."""
    import pandas

    from visualspeech.storage.tables import write_table

    write_table(path, pandas.DataFrame(sorted(digests.items()), columns=["id", "digest"]))


def read_digests(paths: Iterable) -> dict[str, str]:
    """Read the digests of several shards: id -> digest."""
    from visualspeech.storage.tables import read_table

    tables = [read_table(path, ("id", "digest"), required=("id", "digest")) for path in paths]
    return {name: digest for table in tables for name, digest in zip(table["id"], table["digest"], strict=True)}
