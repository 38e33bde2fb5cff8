"""Clips of faces as points: the recorded face beside the predicted one with sound, and controls for other systems.

A drawn face is not a picture of a person, but it shows movements that this person never made; the metadata of every
video therefore say that it is synthetic, as those of the talking head do, and each predicted panel carries the label.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from visualspeech.animation.label import title_bar, title_height
from visualspeech.animation.markers.actor import Actor
from visualspeech.animation.markers.drawing import (
    PREDICTED,
    TRUE,
    drawn_bars,
    drawn_points,
    rows_of_lines,
    view_of,
)
from visualspeech.animation.markers.fap import write_fap
from visualspeech.animation.markers.layouts import frame_of, layout_of
from visualspeech.animation.markers.live_link import write_live_link
from visualspeech.animation.video import Panel, side_by_side
from visualspeech.corpora.records import Utterance
from visualspeech.features.resampling import resample
from visualspeech.media.encoding import write_video

MAX_RATE = 60  # frames per second of a video and of a FAP file
LIVE_LINK_RATE = 60  # of the app, which programs that read its timecodes expect


@dataclass(frozen=True)
class Motion:
    """Points of one utterance.

    Parameters
    ----------
    points : (T, P, d)
    rate : frame rate in Hz
    """

    points: np.ndarray
    rate: float

    def at(self, rate: float, frames: int) -> np.ndarray:
        """Points (frames, P, d) at another frame rate."""
        return resample(self.points, self.rate, rate, frames)


def marker_metadata(utterance: str, corpus: str, model: str, consent: str) -> dict[str, str]:
    """Metadata of a video of drawn points: title, comment, and their parts under keys of their own."""
    permission = consent.strip() or "No statement of consent was given for this corpus."
    return {
        "title": f"{utterance}: recorded and predicted points of a face ({model})",
        "comment": (
            "This video is SYNTHETIC: the points of the panel titled as predicted were computed from speech by a "
            f"model ({model}, corpus {corpus}); the face never moved like this. "
            f"Whose face it is and by what permission: {permission}"
        ),
        "synthetic": "yes",
        "model": model,
        "corpus": corpus,
        "consent": permission,
    }


def video_rate(rate: float, most: float = MAX_RATE) -> float:
    """The largest whole fraction of a frame rate that is at most ``most``."""
    return rate / max(1, int(np.ceil(rate / most - 1e-9)))


def whole_rate(rate: float) -> int:
    """The whole frame rate of a FAP file: that of a video, rounded."""
    return max(1, round(video_rate(rate)))


def write_clip(
    path: str | Path,
    utterance: Utterance,
    names: Sequence[str],
    true: Motion,
    predicted: Motion,
    samples: np.ndarray,
    sample_rate: int,
    metadata: dict[str, str],
    label: bool = True,
) -> None:
    """Write an MP4 of the recorded face beside the predicted one, with sound, titles and a caption.

    The frame rate is that of the recording, or a whole fraction of it.

    Parameters
    ----------
    names : (P,) of the markers or channels
    samples : float sound (n,) in [-1, 1]
    metadata : tags of the file
    label : whether predicted frames carry the label ``synthetic``

    Raises
    ------
    DataError
        Shapes do not fit each other.
    StorageError
        The file cannot be written.
    """
    rate = video_rate(true.rate)  # a faster prediction of a slower recording would show nothing more
    frames = max(1, round(len(predicted.points) / predicted.rate * rate))
    shown, made = true.at(rate, frames), predicted.at(rate, frames)
    caption = ", ".join(filter(None, [utterance.id, utterance.speaker, utterance.emotion]))
    panels = [
        Panel("recorded", drawn(shown, (shown, made), names, TRUE), synthetic=False),
        Panel("predicted (grey: recorded)", drawn(made, (shown, made), names, PREDICTED, shown)),
    ]
    pictures = _captioned(side_by_side(panels, label), caption)
    write_video(path, pictures, rate, samples, sample_rate, metadata)


def drawn(points: np.ndarray, streams: tuple, names: Sequence[str], colour, beneath=None) -> Iterator[np.ndarray]:
    """Frames of one panel; the other streams decide the view, the first of them where the face lies."""
    if points.shape[2] == 1:
        joined = np.concatenate(streams)
        span = float(np.percentile(joined, 0.1)), float(np.percentile(joined, 99.9))
        return drawn_bars(points[..., 0], names, span, colour, None if beneath is None else beneath[..., 0])
    layout = layout_of(names, points.shape[2])
    frame = frame_of(layout, names, streams[0].mean(axis=0)) if layout else None
    return drawn_points(points, view_of(streams, frame), rows_of_lines(layout, frame), colour, beneath)


def _captioned(frames: Iterator[np.ndarray], caption: str) -> Iterator[np.ndarray]:
    """Frames with a bar below that holds the caption."""
    bar = None
    for frame in frames:
        if bar is None:
            bar = title_bar([caption], [frame.shape[1]], title_height(frame.shape[0]))
        yield np.vstack([frame, bar])


def write_controls(folder: str | Path, utterance: Utterance, predicted: Motion, actor: Actor) -> list[Path]:
    """Write the controls of one utterance, ``<id>.fap`` and ``<id>.csv``; returns their paths.

    Controls that the actor's recordings do not move, or that follow from no marker, are left out: masked in the FAP
    file, 0 in the CSV file. A system of which none is left has no file.
    """
    written = []
    for ending, rate, drive, write in (
        (".fap", whole_rate(predicted.rate), actor.faps, write_fap),
        (".csv", LIVE_LINK_RATE, actor.blend_shapes, write_live_link),
    ):
        frames = max(1, round(len(predicted.points) / predicted.rate * rate))
        values = drive(predicted.at(rate, frames))
        if values:
            written.append(Path(folder, f"{utterance.id}{ending}"))
            write(written[-1], values, rate)
    return written
