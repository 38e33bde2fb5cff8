"""Effect of the protocol on the order of the models: scored uncentred against truth without drift, and centred.

Run: python -m benchmarks.centring RESULTS SYSTEM [MODEL ...]

RESULTS is the folder of a corpus (results/grid), SYSTEM a system that was run on it, MODELs some of its trained models
(all). Where drift is removed by the clip mean, every recorded utterance has one and the same mean. A network that sees
the whole utterance can learn that, an HMM cannot, and the uncentred score rewards it. Prints RMSE(appearance) (Eq. 18)
and CORR (Eq. 19) of the test utterances in both ways, and the root mean square of the predicted offset: the mean of a
prediction over its utterance, less that of the truth.
"""

from pathlib import Path

import numpy as np

from benchmarks.command import run_main
from benchmarks.runs import CorpusRun, SystemRun
from visualspeech.evaluation.scoring import centred, frame_correlation, frame_rmse


def main(results: Path, system: str, *models: str) -> None:
    run = SystemRun(CorpusRun(results), system)
    print(f"{'':28s}{'uncentred':>17s}{'centred':>17s}{'offset':>9s}")
    with run.targets() as targets:
        for name in models or run.trained_models():
            sums = np.zeros(6)
            with run.predictions(name) as predictions:
                for one in run.corpus.ids("test"):
                    pair = (predictions.array(one, "appearance"), targets.array(one, "appearance"))
                    predicted, true = map(np.float64, pair)
                    offset = np.mean((predicted.mean(axis=0) - true.mean(axis=0)) ** 2)
                    both = (predicted, true), (centred(predicted), centred(true))
                    errors = [frame_rmse(*each).sum() for each in both]
                    correlations = [np.nan_to_num(frame_correlation(*each)).sum() for each in both]
                    sums += [*errors, *correlations, len(true) * offset, len(true)]
            means = sums[:-1] / sums[-1]
            print(f"{name:28s}{means[0]:9.2f} / {means[2]:.3f}{means[1]:9.2f} / {means[3]:.3f}{means[4] ** 0.5:9.2f}")


if __name__ == "__main__":
    run_main(main, __doc__)
