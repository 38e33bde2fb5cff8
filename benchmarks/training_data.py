"""What more training utterances bring: test RMSE(appearance) and CORR of networks and HMMs on shares of those of a run.

Run: python -m benchmarks.training_data RESULTS EXPERIMENT [NETWORKS [SHARES]]

RESULTS is a corpus's folder (results/grid), EXPERIMENT a folder in it, NETWORKS names of stacks with commas between
(FBB-128,FBB-256), SHARES denominators (4,2,1): a quarter of the training utterances, drawn at random, then half, of
which the quarter is a part, then all. Prints, for each share, each HMM and each network: RMSE(appearance), CORR, and
for networks the gain in RMSE(appearance) over the HMM after minimum generation error.
"""

import sys
from pathlib import Path

import numpy as np
from visualspeech.models.blstm import parse_stack
from visualspeech.models.hmm.examples import TimedExamples, read_tracks
from visualspeech.models.hmm.variants import train_variant
from visualspeech.models.names import HMMS

from benchmarks.runs import alignment_files, rmse_and_corr
from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.features.contexts import read_phones
from visualspeech.features.examples import Examples
from visualspeech.models.hmm.model import HmmSettings
from visualspeech.models.training import train
from visualspeech.storage import ArrayCollection


def main(results: str, experiment: str, networks: str = "FBB-128", shares: str = "4,2,1") -> None:
    corpus, run = Path(results), Path(results, experiment)
    phones, utterances = read_phones(run / "phones.tsv"), read_utterances(run / "utterances.tsv")
    ids = {split: [one.id for one in of_split(utterances, split)] for split in ("train", "validation", "test")}
    tracks = read_tracks(alignment_files(corpus), phones)
    order = np.random.default_rng(1).permutation(len(ids["train"]))
    with ArrayCollection(sorted((run / "features").glob("*.h5"))) as features:
        for share in map(int, shares.split(",")):
            chosen = [ids["train"][number] for number in sorted(order[: len(order) // share])]
            timed = {split: TimedExamples(features, names, tracks) for split, names in ids.items()}
            plain = {split: Examples(features, names) for split, names in ids.items()}
            hmm, last = None, 0.0
            for name in HMMS:
                learned = TimedExamples(features, chosen, tracks)
                hmm = train_variant(name, hmm, learned, timed["validation"], phones, HmmSettings())
                pairs = [(hmm.predict(track, len(truth), rate), truth) for track, truth, rate in timed["test"]]
                last, corr = rmse_and_corr(pairs)
                print(f"{len(chosen)} utterances, {name}: RMSE(appearance) {last:.3f}, CORR {corr:.4f}", flush=True)
            for name in networks.split(","):
                rate = features.rate(chosen[0])
                made = train(parse_stack(name), phones, Examples(features, chosen), plain["validation"], rate)
                rmse, corr = rmse_and_corr([(made.network.predict(labels), truth) for labels, truth in plain["test"]])
                print(
                    f"{len(chosen)} utterances, {name}: RMSE(appearance) {rmse:.3f}, CORR {corr:.4f}, "
                    f"gain over {HMMS[-1]} {1 - rmse / last:.1%}",
                    flush=True,
                )


if __name__ == "__main__":
    main(*sys.argv[1:])
