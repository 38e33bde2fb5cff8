"""What speaking costs and how it looks, of a speaker that the workflow's target `speaker` has written.

Run: python -m benchmarks.speaking SPEAKER [SECONDS]

SPEAKER is the folder of a speaker (results/grid/fan2015/speakers/FBB-128), SECONDS the duration of a long text (300).
Prints frames per second from parameters to the encoded file, at the size of the recordings and at a width of 720
pixels (the same frames enlarged); the change from frame to frame away from the mouth, against that of the recordings;
the opening of the mouth in silence, tracked in the video, against that of the face at rest; and peak memory of a text
of 10 seconds and of the long one, each in a process of its own.
"""

import json
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.command import run_main
from benchmarks.memory import peak_megabytes
from visualspeech.animation.background import QUALITY, Background
from visualspeech.animation.bundle import SpeakerBundle
from visualspeech.animation.performance import perform
from visualspeech.animation.speaking import scene, speak
from visualspeech.face.landmarks import track
from visualspeech.media.reading import read_frames
from visualspeech.models.rest import REST, pause_weights
from visualspeech.speech.spoken import speak_text
from visualspeech.timing import frame_times

SENTENCES = (
    "Place the blue map by the door, please. Why are you so far away now? Bob and Pam put five more bins in the "
    "van at four. I saw them again. The boys will buy a pie soon. Lay white at zero. Most of it was over by noon. "
)


def text_of(seconds: float) -> str:
    """A text of about this duration."""
    return SENTENCES * max(1, round(seconds / 21))


def enlarged(bundle: SpeakerBundle, width: int) -> SpeakerBundle:
    """The same speaker recorded by a camera with more pixels."""
    import cv2

    background, head = bundle.background, bundle.speaker.head
    scale = width / background.size[0]
    size = (width, round(background.size[1] * scale))

    def larger(frame: int) -> bytes:
        picture = cv2.cvtColor(background.frame(frame), cv2.COLOR_RGB2BGR)
        picture = cv2.resize(picture, size, interpolation=cv2.INTER_CUBIC)
        return cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])[1].tobytes()

    jpegs = tuple(larger(frame) for frame in range(len(background)))
    larger_background = replace(background, jpegs=jpegs, landmarks=background.landmarks * scale, size=size)
    larger_head = replace(head, focal=head.focal * scale, centre=head.centre * scale)
    return replace(bundle, background=larger_background, speaker=replace(bundle.speaker, head=larger_head))


def speed(bundle: SpeakerBundle, performance, path: Path) -> None:
    """Print frames per second of rendering and encoding."""
    start, spent = time.perf_counter(), time.process_time()
    speak(path, performance, bundle, "synthetic")
    wall, spent = time.perf_counter() - start, time.process_time() - spent
    frames = performance.seconds * bundle.background.rate
    size = " x ".join(map(str, bundle.background.size))
    speeds = f"{frames / wall:.0f} frames/s on two cores, {frames / spent:.0f} per core"
    print(f"{size}: {speeds}; shown at {bundle.background.rate:g}")


def silent_frames(text: str, bundle: SpeakerBundle) -> np.ndarray:
    """Frames of the performance of a text at which the face is wholly at rest, (T,) bool."""
    found, rate = [], bundle.trained.rate
    for one in speak_text(text, shares=bundle.shares):
        frames = max(1, int(np.ceil(len(one.samples) / one.rate * rate - 1e-6)))
        found.append(pause_weights(one.alignment, frames, rate, REST) == 1)
    return np.concatenate(found)


def opening(points: np.ndarray) -> np.ndarray:
    """Height of the inner mouth over the distance of the eyes' outer corners, in percent, of landmarks (T, 68, 2)."""
    eyes = np.linalg.norm(points[:, 45] - points[:, 36], axis=1)
    return 100 * np.linalg.norm(points[:, 66] - points[:, 62], axis=1) / eyes


def steps_away_from_the_mouth(frames, landmarks: np.ndarray) -> np.ndarray:
    """Mean change of the grey levels of the upper part of a frame from one frame to the next."""
    import cv2

    until = int(np.median(landmarks[:, 33, 1]))
    small = [cv2.resize(frame[:until], None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA) for frame in frames]
    small = np.stack(small).astype(np.float32).mean(axis=3)
    return np.abs(np.diff(small, axis=0)).mean(axis=(1, 2))


def peak(folder: Path, seconds: float) -> dict:
    """Peak memory of a process that speaks so long a text."""
    command = [sys.executable, "-m", "benchmarks.speaking", str(folder), str(seconds), "only"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return json.loads(done.stdout.splitlines()[-1])


def once(folder: Path, seconds: float) -> None:
    """Speak a text of so many seconds and print what it cost, as one line of JSON."""
    start = time.perf_counter()
    bundle = SpeakerBundle.load(folder)
    performance = perform(speak_text(text_of(seconds), shares=bundle.shares), bundle.trained, bundle.rest)
    heard = time.perf_counter() - start
    with tempfile.TemporaryDirectory() as scratch:
        speak(Path(scratch, "a.mp4"), performance, bundle, "synthetic")
    wall = time.perf_counter() - start
    cost = {"seconds": performance.seconds, "heard": heard, "wall": wall, "megabytes": peak_megabytes()}
    print(json.dumps(cost))


def main(folder: Path, seconds: float = 300.0, only: str = "") -> None:
    if only:
        return once(folder, seconds)
    bundle = SpeakerBundle.load(folder)
    performance = perform(speak_text(SENTENCES, shares=bundle.shares), bundle.trained, bundle.rest)
    with tempfile.TemporaryDirectory() as scratch:
        path = Path(scratch, "a.mp4")
        speed(enlarged(bundle, 720), performance, Path(scratch, "b.mp4"))
        speed(bundle, performance, path)
        frames = list(read_frames(path))
    background: Background = bundle.background
    recorded = [background.frame(frame) for frame in range(len(background))]
    same = np.diff(background.clip) == 0
    before = steps_away_from_the_mouth(recorded, background.landmarks)[same]
    shown = scene(background, len(frames))
    after = steps_away_from_the_mouth(frames, shown.landmarks)
    mixed = sum(mix.share > 0 for mix in shown.mixes) / len(shown.mixes)
    print(
        f"change away from the mouth, grey levels: recorded {np.median(before):.2f} (largest {before.max():.2f}), "
        f"shown {np.median(after):.2f} (largest {after.max():.2f}); {100 * mixed:.0f} % of the frames are mixed"
    )
    quiet = silent_frames(SENTENCES, bundle)
    quiet = quiet[
        np.minimum((frame_times(len(frames), background.rate) * bundle.trained.rate).astype(int), len(quiet) - 1)
    ]
    tracked = opening(track(iter(frames), rate=background.rate).points)
    aam = bundle.speaker.aam
    lips = aam.points.region(aam.decode_points(bundle.rest[None]), "inner_lips")[0]
    eyes = bundle.speaker.head.mean_points[[36, 45]]
    rest = 100 * np.linalg.norm(lips[6] - lips[2]) / np.linalg.norm(eyes[1] - eyes[0])
    print(
        f"mouth opening, % of the eyes' distance: at rest {rest:.1f}; in silence median "
        f"{np.median(tracked[quiet]):.1f}, 95th percentile "
        f"{np.percentile(tracked[quiet], 95):.1f} ({quiet.sum()} frames); in speech median "
        f"{np.median(tracked[~quiet]):.1f}, 95th percentile {np.percentile(tracked[~quiet], 95):.1f}"
    )
    for length in (10.0, seconds):
        cost = peak(folder, length)
        print(
            f"{cost['seconds']:.0f} s of speech: {cost['megabytes']:.0f} MB at most, voice and model "
            f"{cost['heard']:.1f} s, all {cost['wall']:.1f} s"
        )


if __name__ == "__main__":
    run_main(main, __doc__)
