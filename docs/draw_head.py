"""Make docs/head.jpg, the picture at the top of the README, from frames of a video of the demo corpus.

Run: python docs/draw_head.py results/demo/fan2015/videos/demo010.mp4 40 58
"""

import sys
from pathlib import Path

import cv2
import numpy as np

from visualspeech.media.reading import read_frames


def main() -> None:
    video, *numbers = sys.argv[1:]
    frames = list(read_frames(video))
    rows = [frames[int(numbers[0])], *(frames[int(number)][26:] for number in numbers[1:])]
    cv2.imwrite(str(Path(__file__).with_name("head.jpg")), np.vstack(rows)[:, :, ::-1], [cv2.IMWRITE_JPEG_QUALITY, 88])


if __name__ == "__main__":
    main()
