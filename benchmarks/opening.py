"""Cost of opening a media file and reading its header, beside PyAV without restrictions.

Run: python -m benchmarks.opening [ROUNDS]

Opens a small recording in turn with ``av.open(path)`` and with this project's ``open_media`` (local files only, known
containers only), in changing order, and prints the median time of each and the median ratio of a round. Both probe the
streams, which takes nearly all of the time.
"""

import time
from collections.abc import Callable
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import av
import numpy as np

from benchmarks.command import run_main
from tests import synthetic
from visualspeech.errors import RejectedUtterance
from visualspeech.media.decoding import open_media


def seconds(function: Callable, path: Path) -> float:
    """Time of opening and closing a file once."""
    begin = time.perf_counter()
    with function(path):
        pass
    return time.perf_counter() - begin


@contextmanager
def plain_media(path: Path):
    """What ``open_media`` does, without its restrictions."""
    try:
        with av.open(str(path)) as container:
            yield container
    except (av.FFmpegError, OSError) as error:
        raise RejectedUtterance(str(error)) from error


def main(rounds: int = 500) -> None:
    with TemporaryDirectory() as folder:
        for name, codecs in (("a.mp4", ("libx264", "aac")), ("a.mpg", ("mpeg1video", "mp2"))):
            path = synthetic.record(Path(folder, name), 3.0, codecs=codecs, audio_rate=44100)
            ways = {"without restrictions": plain_media, "open_media": open_media}
            times = {title: [] for title in ways}
            for number in range(rounds):
                for title in list(ways)[:: 1 if number % 2 else -1]:
                    times[title].append(seconds(ways[title], path))
            plain, ours = (1000 * np.median(times[title]) for title in ways)
            ratio = np.median(np.divide(times["open_media"], times["without restrictions"]))
            print(f"{name}: without restrictions {plain:.3f} ms, open_media {ours:.3f} ms, ratio {ratio:.3f}")


if __name__ == "__main__":
    run_main(main, __doc__)
