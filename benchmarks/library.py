"""What the library costs a program: its imports, loading a speaker, and the first frame of a request.

Run: python -m benchmarks.library [SPEAKER]

SPEAKER is the folder of a speaker (results/demo/fan2015/speakers/FBB-128-lips). Prints the seconds of importing each
public name in a process of its own, less those of starting Python, with the heavy modules that come with it; and for a
speaker the seconds of loading it and from a request until its first frame, for the first request and for later ones,
and those of a whole file.
"""

import json
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


def requests(folder: Path) -> None:
    """Print what a speaker costs, once the library is imported."""
    from visualspeech import Speaker

    start = time.perf_counter()
    Speaker.load(folder)
    first = time.perf_counter() - start  # reads torch and the model's family
    start = time.perf_counter()
    speaker = Speaker.load(folder)
    print(f"loading a speaker: {time.perf_counter() - start:.2f} s, the first time in a process {first:.2f} s")

    def until_frame(text: str) -> float:
        start = time.perf_counter()
        next(iter(speaker.say(text)))
        return time.perf_counter() - start

    first, later = until_frame(TEXTS[0]), [until_frame(text) for text in TEXTS * 3]
    print(f"request to first frame: {first:.2f} s, later requests {statistics.median(later):.2f} s")
    said = speaker.say(LONG)
    print(f"request to first frame of {said.seconds:.0f} s of speech: {until_frame(LONG):.2f} s")
    said = speaker.say(TEXTS[1])
    start = time.perf_counter()
    size = len(said.mp4())
    print(f"file of {said.seconds:.1f} s of speech: {time.perf_counter() - start:.2f} s, {size / 1000:.0f} kB")


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
