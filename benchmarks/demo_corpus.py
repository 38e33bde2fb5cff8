"""Figures of the demo corpus: recording speed, and the face tracker against the truth.

Run: python -m benchmarks.demo_corpus [UTTERANCES]

Records so many utterances (6) in a temporary folder. Prints milliseconds of processor time per recorded frame, the
number of frames without exactly one detected face, and the opening of the lips as tracked against the true one.
"""

import importlib.util
import tempfile
import time
from pathlib import Path

import cv2
import dlib
import numpy as np

from benchmarks.command import run_main
from visualspeech.corpora.demo.listing import utterances
from visualspeech.corpora.demo.recording import read_truth, record_shard
from visualspeech.media.reading import read_frames
from visualspeech.storage.arrays import ArrayReader

UPPER, LOWER = [61, 62, 63], [67, 66, 65]


def tracked_points(media: str) -> tuple[np.ndarray, list[int]]:
    """Points (n, 68, 2) of the frames with exactly one face, and the number of faces of every frame."""
    folder = Path(importlib.util.find_spec("face_recognition_models").origin).parent / "models"
    predictor = dlib.shape_predictor(str(folder / "shape_predictor_68_face_landmarks.dat"))
    detector = dlib.get_frontal_face_detector()
    points, faces = [], []
    for frame in read_frames(media):
        found = detector(frame)
        faces.append(len(found))
        if len(found) == 1:
            large = cv2.resize(frame, None, fx=4, fy=4, interpolation=cv2.INTER_CUBIC)
            sides = (found[0].left(), found[0].top(), found[0].right(), found[0].bottom())
            shape = predictor(large, dlib.rectangle(*(4 * side for side in sides)))
            points.append([(point.x / 4 - 0.375, point.y / 4 - 0.375) for point in shape.parts()])
    return np.array(points), faces


def main(count: int = 6) -> None:
    with tempfile.TemporaryDirectory() as folder:
        listed = utterances({"root": folder, "utterances": count})
        began, used = time.monotonic(), time.process_time()
        record_shard(listed, folder, f"{folder}/truth.h5")
        seconds, processor = time.monotonic() - began, time.process_time() - used
        faces, tracked, true, closed = [], [], [], []
        with ArrayReader(f"{folder}/truth.h5") as reader:
            for utterance in listed:
                truth = read_truth(reader, utterance.id)
                points, found = tracked_points(utterance.media)
                one = np.array(found) == 1
                faces += found
                tracked.append((points[:, LOWER, 1] - points[:, UPPER, 1]).mean(axis=1))
                true.append((truth.points[one][:, LOWER, 1] - truth.points[one][:, UPPER, 1]).mean(axis=1))
                closed.append(truth.parameters[one, 0] <= 0)
        tracked, true, closed = (np.concatenate(parts) for parts in (tracked, true, closed))
        print(
            f"{len(faces)} frames recorded in {seconds:.1f} s, "
            f"{1000 * processor / len(faces):.1f} ms of processor time per frame"
        )
        print(f"frames without exactly one face: {sum(count != 1 for count in faces)}")
        print(f"lip opening, tracked against true: r = {np.corrcoef(tracked, true)[0, 1]:.3f}")
        shut, wide = np.median(tracked[closed]), np.median(tracked[true > 8])
        print(f"median tracked opening: closed {shut:.1f} px, wide open {wide:.1f} px")


if __name__ == "__main__":
    run_main(main, __doc__)
