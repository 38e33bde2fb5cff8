"""What the settings of the HMMs do, on the validation utterances of a finished run, and what training costs.

Run: python -m benchmarks.hmm RESULTS EXPERIMENT VARIANT KEY=VALUE[,KEY=VALUE...] ...

RESULTS is a corpus's folder (results/grid), EXPERIMENT a folder in it, VARIANT hmm_monophone, hmm_tied or hmm_mge: how
far each set of settings is trained. Prints for each set and each variant on the way: RMSE(appearance) and CORR (Eq. 18
and 19), Gaussians, the generation error on training and validation utterances, and seconds.
"""

import json
import sys
import time
from pathlib import Path

from visualspeech.models.hmm.examples import TimedExamples, read_tracks
from visualspeech.models.hmm.variants import train_variant
from visualspeech.models.names import HMMS

from benchmarks.runs import alignment_files, rmse_and_corr
from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.features.contexts import read_phones
from visualspeech.models.hmm.mge import generation_error
from visualspeech.models.hmm.model import HmmSettings
from visualspeech.storage import ArrayCollection


def main(results: str, experiment: str, last: str, *changes: str) -> None:
    corpus, run = Path(results), Path(results, experiment)
    phones = read_phones(run / "phones.tsv")
    utterances = read_utterances(run / "utterances.tsv")
    tracks = read_tracks(alignment_files(corpus), phones)
    with ArrayCollection(sorted((run / "features").glob("*.h5"))) as features:
        training, validation = (
            TimedExamples(features, [one.id for one in of_split(utterances, split)], tracks)
            for split in ("train", "validation")
        )
        kept: dict[tuple, object] = {}
        for change in changes or ("",):
            given = dict(pair.split("=") for pair in change.split(",") if pair)
            settings = HmmSettings(**{key: json.loads(value) for key, value in given.items()})
            hmm = None
            for name in HMMS[: HMMS.index(last) + 1]:
                # What only later variants look at need not be trained again.
                key = (name, tuple(item for item in sorted(given.items()) if not _later(item[0], name)))
                start = time.perf_counter()
                if key not in kept:
                    kept[key] = train_variant(name, hmm, training, validation, phones, settings)
                hmm = kept[key]
                seconds = time.perf_counter() - start
                print(change or "default", name, _figures(hmm, training, validation), f"{seconds:.1f} s", flush=True)


def _later(setting: str, name: str) -> bool:
    mge = setting.startswith("mge_")
    tied = setting in ("mdl_factor", "map_tau", "min_frames", "tree_per_phone") or setting.startswith(
        ("tied_", "untied_")
    )
    return (mge and name != "hmm_mge") or (tied and name == "hmm_monophone")


def _figures(hmm, training, validation) -> str:
    rmse, corr = rmse_and_corr((hmm.predict(track, len(truth), rate), truth) for track, truth, rate in validation)
    generation = [generation_error(hmm, part) for part in (training, validation)]
    return (
        f"RMSE(appearance) {rmse:.3f}, CORR {corr:.4f}, {hmm.tying.gaussians} Gaussians, "
        f"generation error {generation[0]:.0f} training, {generation[1]:.0f} validation,"
    )


if __name__ == "__main__":
    main(*sys.argv[1:])
