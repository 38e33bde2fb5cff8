"""What the library costs a program: its imports, loading a speaker, and the first frame of a request.

Run: python -m benchmarks.api [SPEAKER]

SPEAKER is the folder of a speaker (results/demo/fan2015/speakers/FBB-128-lips). Prints the seconds of importing each
public name in a process of its own, less those of starting Python, with the heavy modules that come with it; and for a
speaker the seconds of loading it and from a request until its first frame, for the first request and for later ones,
and those of a whole file.
"""

import json
import resource
import statistics
import subprocess
import sys
import time
from pathlib import Path

from benchmarks.command import run_main
from visualspeech.api import PUBLIC

HEAVY = ("torch", "pandas", "scipy", "cv2", "av", "dlib")
TEXTS = ("I never said this.", "Place the blue map by the door, please.", "Why are you so far away now?")
LONG = "Bob and Pam put five more bins in the van at four. " * 10
_IMPORT = """
import json, sys, time
start = time.perf_counter()
{statement}
spent = time.perf_counter() - start
print(json.dumps([spent, [name for name in {heavy} if name in sys.modules]]))
"""


def imported(statement: str, rounds: int = 3) -> tuple[float, list[str]]:
    """Least seconds of an import in a new process, and the heavy modules that it loads."""
    command = [sys.executable, "-c", _IMPORT.format(statement=statement, heavy=list(HEAVY))]
    found = [
        json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout) for _ in range(rounds)
    ]
    return min(spent for spent, _ in found), found[0][1]


class Timer:
    """Wall-clock and processor time since it was made, with that of processes that have ended, as text."""

    def __init__(self) -> None:
        self._wall, self._spent = time.perf_counter(), self._processor()

    @staticmethod
    def _processor() -> float:
        found = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
        return sum(one.ru_utime + one.ru_stime for one in found)

    def read(self) -> tuple[float, float]:
        """Seconds of either."""
        return time.perf_counter() - self._wall, self._processor() - self._spent


def shown(spent: tuple[float, float]) -> str:
    """Seconds as text."""
    return "{:.2f} s ({:.2f} s of processor time)".format(*spent)


def requests(folder: Path) -> None:
    """Print what a speaker costs, once the library is imported."""
    from visualspeech import Speaker

    timer = Timer()
    Speaker.load(folder)
    first = timer.read()  # loads torch and the model's family
    timer = Timer()
    speaker = Speaker.load(folder)
    print(f"loading a speaker: {shown(timer.read())}; the first time in a process {shown(first)}")

    def until_frame(text: str) -> tuple[float, float]:
        timer = Timer()
        next(iter(speaker.say(text)))
        return timer.read()

    first, later = until_frame(TEXTS[0]), [until_frame(text) for text in TEXTS * 3]
    middle = tuple(map(statistics.median, zip(*later, strict=True)))
    print(f"request to first frame: {shown(first)}; later requests {shown(middle)}")
    said = speaker.say(LONG)
    print(f"request to first frame of {said.seconds:.0f} s of speech: {shown(until_frame(LONG))}")
    said, timer = speaker.say(TEXTS[1]), Timer()
    size = len(said.mp4())
    print(f"file of {said.seconds:.1f} s of speech: {shown(timer.read())}, {size / 1000:.0f} kB")


def main(speaker: str = "") -> None:
    seconds, modules = imported("import visualspeech")
    print(f"import visualspeech: {1000 * seconds:.1f} ms{'; loads ' * bool(modules)}{', '.join(modules)}")
    for module in dict.fromkeys(PUBLIC.values()):
        names = [name for name, own in PUBLIC.items() if own == module]
        seconds, modules = imported(f"from visualspeech import {', '.join(names)}")
        print(f"from visualspeech import {', '.join(names)}: {seconds:.2f} s; loads {', '.join(modules) or '-'}")
    if speaker:
        requests(Path(speaker))


if __name__ == "__main__":
    run_main(main, __doc__)
