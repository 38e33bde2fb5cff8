"""Videos of the report: a still of each, and the bytes of those that are small enough to stand in the page itself."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import zip_longest
from pathlib import Path

from visualspeech.corpora.records import Utterance
from visualspeech.errors import RejectedUtterance
from visualspeech.evaluation.report import Video
from visualspeech.media.reading import probe, read_frames

#: Videos at the top of the page, and those of a system that have a still; further ones are links.
STRIP, STILLS = 6, 12
#: Bytes of a video that is embedded, and of all embedded ones together.
MAX_EMBEDDED, MAX_TOGETHER = 600_000, 3_000_000
STILL_WIDTH = 480  # pixels
STILL_TIME = 0.8  # seconds; the frame shown, that of a shorter video is its last one
JPEG_QUALITY = 72


def videos(folder: str, report: str, utterances: Sequence[Utterance], model: str, system: str) -> tuple[Video, ...]:
    """The videos in a folder by name, the first ones with a still.

    Parameters
    ----------
    folder : of MP4 files named by utterances
    report : path of the page, to which links are relative
    model, system : titles of what the videos show
    """
    transcripts = {one.id: one.transcript for one in utterances}
    base = Path(report).parent
    return tuple(
        Video(
            path.relative_to(base).as_posix(),
            path.stem,
            transcripts.get(path.stem, ""),
            model,
            system,
            still(path) if number < STILLS else b"",
        )
        for number, path in enumerate(sorted(Path(folder).glob("*.mp4")))
    )


def still(path: str | Path) -> bytes:
    """A frame of a video as the bytes of a small JPEG; none of a video that cannot be read."""
    import cv2

    try:
        rate = probe(path).rate
        *_, frame = read_frames(path, 0.0, STILL_TIME + 1 / rate)
    except (RejectedUtterance, ValueError):
        return b""
    height, width = frame.shape[:2]
    if width > STILL_WIDTH:
        size = STILL_WIDTH, max(1, round(height * STILL_WIDTH / width))
        frame = cv2.resize(frame, size, interpolation=cv2.INTER_AREA)
    made, jpeg = cv2.imencode(".jpg", frame[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    return jpeg.tobytes() if made else b""


def strip(systems: Sequence[Sequence[Video]], report: str) -> tuple[Video, ...]:
    """The videos at the top of the page, with their bytes where they are small.

    Utterances that most systems show come first, so that the same words stand side by side.

    Parameters
    ----------
    systems : the videos of each system
    report : path of the page
    """
    count: dict[str, int] = {}
    for one in (video for own in systems for video in own):
        count[one.utterance] = count.get(one.utterance, 0) + 1
    ordered = [sorted(own, key=lambda one: (-count[one.utterance], one.utterance)) for own in systems]
    turns = [one for turn in zip_longest(*ordered) for one in turn if one is not None and one.still]
    left, chosen = MAX_TOGETHER, []
    for one in turns[:STRIP]:
        path = Path(report).parent / one.path
        size = path.stat().st_size
        if size <= min(MAX_EMBEDDED, left):
            left -= size
            one = replace(one, content=path.read_bytes())
        chosen.append(one)
    return tuple(chosen)
