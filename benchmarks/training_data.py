"""What more training utterances bring: test RMSE(appearance) and CORR of HMMs and networks on shares of those of a run.

Run: python -m benchmarks.training_data RESULTS SYSTEM [NETWORKS [SHARES]]

RESULTS is the folder of a corpus (results/grid), SYSTEM a system that was run on it, NETWORKS names of its networks
with commas between (FBB-128,FBB-64), SHARES denominators (4,2,1): a quarter of the training utterances, drawn at
random, then half, which contains the quarter, then all. Models are trained with the settings that they have in the run.
Prints for each share and each model: RMSE(appearance), CORR, and for networks the gain: by how much RMSE(appearance) is
below that of the last HMMs.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.command import run_main
from benchmarks.runs import VARIANTS, CorpusRun, SystemRun, fit_hmm, retrained, rmse_and_corr
from visualspeech.models.hmm.family import HmmModel


def main(results: Path, system: str, networks: str = "FBB-128", shares: str = "4,2,1") -> None:
    run = SystemRun(CorpusRun(results), system)
    hmms: HmmModel = run.model(run.last_hmm())
    models = {name: run.model(name) for name in networks.split(",")}
    training = run.corpus.ids("train")
    order = np.random.default_rng(1).permutation(len(training))
    for share in map(int, shares.split(",")):
        chosen = [training[number] for number in sorted(order[: max(1, len(order) // share)])]
        count = f"{len(chosen)} utterances"
        found, error = None, 0.0
        for settings in _stages(hmms):
            with run.examples(list(hmms.blocks)) as examples:
                learned, validation, test = (examples(ids) for ids in _sets(run.corpus, chosen))
                found = fit_hmm(settings, hmms.blocks, learned, validation, found)
                error, corr = rmse_and_corr(found, test)
            print(f"{count}, HMM {settings.variant}: RMSE(appearance) {error:.3f}, CORR {corr:.4f}", flush=True)
        for name, model in models.items():
            with run.examples(list(model.blocks)) as examples:
                learned, validation, test = (examples(ids) for ids in _sets(run.corpus, chosen))
                rmse, corr = rmse_and_corr(retrained(model, name, learned, validation), test)
            print(
                f"{count}, {name}: RMSE(appearance) {rmse:.3f}, CORR {corr:.4f}, gain over HMM "
                f"{hmms.hmm.settings.variant} {1 - rmse / error:.1%}",
                flush=True,
            )


def _stages(model: HmmModel) -> list:
    """Settings of each variant up to that of trained HMMs."""
    settings = model.hmm.settings
    return [replace(settings, variant=variant) for variant in VARIANTS[: VARIANTS.index(settings.variant) + 1]]


def _sets(corpus: CorpusRun, training: list[str]) -> tuple[list[str], list[str], list[str]]:
    """Ids of training, validation and test utterances."""
    return training, corpus.ids("validation"), corpus.ids("test")


if __name__ == "__main__":
    run_main(main, __doc__)
