"""How much of the recorded variance the rate of the HMMs leaves: from the frames to that rate and back.

Run: python -m benchmarks.hmm_rates RESULTS SYSTEM [HZ ...]

RESULTS is the folder of a finished run, for example results/grid; HZ are rates, by default 50, 75, 100 and 125. The
variance is that of all parameters of the training utterances, each less its mean over the utterance. "Mean" takes the
mean over each frame, "centre" reads the stream at the frame's centre, as the HMMs are read.
"""

from pathlib import Path

import numpy as np

from benchmarks.command import run_main
from benchmarks.runs import CorpusRun, SystemRun
from visualspeech.features.resampling import at_times, resample
from visualspeech.timing import frame_times


def main(results: Path, system: str, *rates: str) -> None:
    run = SystemRun(CorpusRun(results), system)
    for rate in map(float, rates or (50, 75, 100, 125)):
        sums = np.zeros(3)
        with run.targets() as targets:
            for name in run.corpus.ids("train"):
                if name in targets:
                    values, own = targets.array(name, "appearance").astype(np.float64), targets.rate(name)
                    inner, times = resample(values, own, rate), frame_times(len(values), own)
                    read = resample(inner, rate, own, len(values)), at_times(inner, rate, times)
                    sums += [((one - one.mean(axis=0)) ** 2).sum() for one in (values, *read)]
        print(f"{rate:g} Hz: mean {sums[1] / sums[0]:.3f}, centre {sums[2] / sums[0]:.3f}", flush=True)


if __name__ == "__main__":
    run_main(main, __doc__)
