"""Load of a study: many simulated participants at once at one server.

Run: python -m benchmarks.study [PARTICIPANTS [ITEMS [PAUSE]]]

Starts ``visualspeech study serve --rehearse`` on a small preference study as a process of its own, lets PARTICIPANTS
(50) take part at the same time, each with ITEMS (20) videos and PAUSE (0) seconds before each answer, and prints how
long pages and answers took (videos aside), and whether every confirmed answer was stored once. Without a pause, the
server is as busy as it can be; people watch a video of some seconds before each answer.
"""

import os
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.command import run_main
from tests.unit.study import studies
from visualspeech.study.records import read_answers, read_key, read_participants, read_study
from visualspeech.study.simulation import Behaviour, checked_behaviour, simulate_at


def main(participants: int = 50, items: int = 20, pause: float = 0.0) -> None:
    with TemporaryDirectory() as temporary:
        folder = studies.make(Path(temporary, "study"), sentences=items, seconds=0.2)
        study, key = read_study(folder), read_key(folder)
        command = [sys.executable, "-m", "visualspeech", "study", "serve", str(folder), "--rehearse", "--port", "0"]
        server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=os.environ)
        try:
            address = server.stdout.readline().split()[1]
            behaviour = checked_behaviour(Behaviour(), study, key)
            begin = time.perf_counter()
            done = simulate_at(address, study, key, participants, behaviour, 1, participants, folder, pause)
            seconds = time.perf_counter() - begin
        finally:
            server.terminate()
            server.wait()
        answers = read_answers(folder, simulated=True)
        people = read_participants(folder, simulated=True)
    unique = {(one.participant, one.item, one.question) for one in answers}
    times = 1000 * np.array(done.seconds)
    print(
        f"{participants} participants at once, {len(times)} requests in {seconds:.1f} s ({len(times) / seconds:.0f}/s)"
    )
    print(f"page or answer: median {np.median(times):.0f} ms, 95 % within {np.percentile(times, 95):.0f} ms, "
          f"longest {times.max():.0f} ms")  # fmt: skip
    print(f"answers confirmed {done.answers}, stored {len(answers)}, different {len(unique)}; "
          f"participants {len(people)}, finished {sum(bool(one.finished) for one in people)}")  # fmt: skip


if __name__ == "__main__":
    run_main(main, __doc__)
