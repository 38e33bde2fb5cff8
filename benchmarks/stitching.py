"""How well rendered mouths fit into the recording, on the test utterances of a finished run.

Run: python -m benchmarks.stitching RESULTS [CODING [UTTERANCES]]

RESULTS is the folder of a corpus (results/grid), CODING a visual coding of it (aam51), UTTERANCES how many of the test
utterances are rendered (8). Prints, for the reconstruction of an utterance's own mouth and for the mouth of another
utterance (which differs from the recorded one in every frame):

seam, surroundings : second difference over time (flicker) and standard deviation of the rendered pixels, as ratios to
    those of the recording; along the seam in coordinates of the face, around the jaw in those of the frame
opening : height of the inner mouth as tracked in the rendered video against that of the target
drift : how far the mouth's centre moves against its target between the first and the last third
"""

from pathlib import Path

import cv2
import numpy as np

from benchmarks.command import run_main
from benchmarks.runs import CodingRun, CorpusRun
from visualspeech.animation.rendering import place, prepare
from visualspeech.animation.video import Recording, Speaker, synthetic_frames
from visualspeech.face.aam.model import Aam
from visualspeech.face.aam.reference import Reference, sample_texture
from visualspeech.face.landmarks import track
from visualspeech.face.point_sets import PointSet, to_points
from visualspeech.face.pose import to_frontal
from visualspeech.media.reading import read_frames


def flicker(values: np.ndarray) -> float:
    return float(np.sqrt((np.diff(values.astype(np.float32), 2, axis=0) ** 2).mean()))


def around_jaw(placement, points: PointSet, shape) -> np.ndarray:
    """Mask of the pixels near the face but never on it, below the eyes."""
    face = np.zeros(shape, np.uint8)
    for recorded in placement.recorded:
        cv2.fillPoly(face, [np.rint(recorded[points.outline]).astype(np.int32)], 1)
    wide = int(np.ptp(placement.recorded[:, points.regions["jaw"], 0].mean(0)))
    ring = cv2.dilate(face, np.ones((wide // 2, wide // 2))) - cv2.dilate(face, np.ones((7, 7)))
    ring[: int(placement.recorded[:, 0, 1].min())] = 0
    return ring > 0


def measure(utterance, recording, appearance, speaker, rate) -> list[float]:
    recorded = list(read_frames(utterance.media, utterance.start, utterance.end))
    rendered = list(synthetic_frames(recorded, appearance, recording, speaker, rate=rate))
    shape = speaker.aam.decode(appearance)[0] + (recording.drift.shape - speaker.aam.drift.shape)
    points, size = speaker.reference.points, speaker.reference.points.size
    placement = place(recording.landmarks, shape, recording.pose, speaker.head, points, rate=rate)
    opacity = prepare(speaker.reference).opacity[tuple(speaker.reference.pixels.T)]
    seam = np.tile((opacity > 0.02) & (opacity < 0.98), 3)
    ring = around_jaw(placement, points, recorded[0].shape[:2])
    before, after = (
        np.stack([sample_texture(frame, at[:size], speaker.reference)[seam] for frame, at in zip(*pair, strict=True)])
        for pair in ((recorded, placement.recorded), (rendered, placement.target))
    )
    outside, moved = (np.stack([frame[ring] for frame in frames]) for frames in (recorded, rendered))
    tracked = track(iter(rendered), rate=rate).points.astype(float)
    seen = points.select(to_frontal(tracked, recording.pose, speaker.head))
    target, (upper, lower) = to_points(shape), points.mouth_middle
    opening, wanted = (face[:, lower, 1] - face[:, upper, 1] for face in (seen, target))
    away = points.region(seen, "lips").mean(1) - points.region(target, "lips").mean(1)
    third = max(1, len(away) // 3)
    return [
        flicker(after) / flicker(before),
        after.std(0).mean() / before.std(0).mean(),
        flicker(moved) / flicker(outside),
        moved.std(0).mean() / outside.std(0).mean(),
        np.corrcoef(opening, wanted)[0, 1],
        (opening - wanted).mean(),
        float(np.linalg.norm(away[-third:].mean(0) - away[:third].mean(0))),
    ]


def main(results: Path, coding: str = "aam51", count: int = 8) -> None:
    corpus = CorpusRun(results)
    made = CodingRun(corpus, coding)
    aam, reference = Aam.load(made.model), Reference.load(made.reference)
    utterances = corpus.of_split("test")[:count]
    figures = {"own mouth": [], "other mouth": []}
    with (
        corpus.landmarks() as landmarks,
        corpus.pose() as poses,
        made.coded_faces() as textures,
        made.parameters() as parameters,
    ):
        for utterance, other in zip(utterances, utterances[1:] + utterances[:1], strict=True):
            speaker = Speaker(corpus.head(utterance.speaker), aam, reference)
            recording = Recording.read(landmarks, poses, textures, utterance.id)
            for name, source in (("own mouth", utterance.id), ("other mouth", other.id)):
                appearance = parameters.array(source, "appearance")
                if name == "other mouth":
                    appearance = appearance[np.minimum(np.arange(len(recording.pose)), len(appearance) - 1)]
                rate = landmarks.rate(utterance.id)
                figures[name].append(measure(utterance, recording, appearance, speaker, rate))
    for name, rows in figures.items():
        values = np.mean(rows, axis=0)
        print(
            f"{name}, ratios to the recording: seam flicker {values[0]:.2f}, deviation {values[1]:.2f}; surroundings "
            f"flicker {values[2]:.2f}, deviation {values[3]:.2f}; opening correlation {values[4]:.3f}, "
            f"bias {values[5]:+.2f} px; drift {values[6]:.2f} px ({len(rows)} utterances)"
        )


if __name__ == "__main__":
    run_main(main, __doc__)
