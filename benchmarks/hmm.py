"""What the settings of the HMMs change, on the validation utterances of a finished run, and what training costs.

Run: python -m benchmarks.hmm RESULTS SYSTEM MODEL [KEY=VALUE[,KEY=VALUE...] ...]

RESULTS is the folder of a corpus (results/grid), SYSTEM a system that was run on it, MODEL one of its HMMs
(hmm_monophone, hmm_tied or hmm_mge): each set of changes to its settings is trained from the start up to its variant.
Prints for each set and each variant: centred RMSE(appearance) and CORR (Eq. 18 and 19), number of Gaussians, generation
error on training and validation utterances, and seconds.
"""

import json
import time
from dataclasses import replace
from pathlib import Path

from benchmarks.command import run_main
from benchmarks.runs import VARIANTS, CorpusRun, SystemRun, fit_hmm, rmse_and_corr
from visualspeech.models.hmm.family import HmmModel, Tracks
from visualspeech.models.hmm.mge import generation_error


def main(results: Path, system: str, model: str, *changes: str) -> None:
    run = SystemRun(CorpusRun(results), system)
    trained: HmmModel = run.model(model)
    base, blocks = trained.hmm.settings, trained.blocks
    with run.examples(list(blocks)) as examples:
        training, validation = (examples(run.corpus.ids(split)) for split in ("train", "validation"))
        kept: dict[tuple, HmmModel] = {}
        for change in changes or ("",):
            given = dict(pair.split("=") for pair in change.split(",") if pair)
            settings = replace(base, **{key: value_of(text) for key, text in given.items()})
            found = None
            for variant in VARIANTS[: VARIANTS.index(base.variant) + 1]:
                # What only later variants read need not be trained again.
                key = (variant, tuple(item for item in sorted(given.items()) if not _later(item[0], variant)))
                begin = time.perf_counter()
                if key not in kept:
                    kept[key] = fit_hmm(replace(settings, variant=variant), blocks, training, validation, found)
                found = kept[key]
                seconds = time.perf_counter() - begin
                figures = _figures(found, training, validation)
                print(f"{change or 'as in the run'}: {variant}: {figures}, {seconds:.1f} s", flush=True)


def value_of(text: str):
    """A number or truth value as JSON writes it; anything else is text."""
    try:
        return json.loads(text)
    except ValueError:
        return text


def _later(setting: str, variant: str) -> bool:
    """Whether only variants after this one read a setting."""
    mge = setting.startswith("mge_")
    tied = setting in ("mdl_factor", "map_tau", "min_frames", "tree_per_phone") or setting.startswith(
        ("tied_", "untied_")
    )
    return (mge and variant != "mge") or (tied and variant == "monophone")


def _figures(model: HmmModel, training, validation) -> str:
    rmse, corr = rmse_and_corr(model, validation, centred=True)
    errors = [generation_error(model.hmm, Tracks(part, model.blocks)) for part in (training, validation)]
    return (
        f"RMSE(appearance) {rmse:.3f}, CORR {corr:.4f}, {model.hmm.tying.gaussians} Gaussians, "
        f"generation error {errors[0]:.0f} training, {errors[1]:.0f} validation"
    )


if __name__ == "__main__":
    run_main(main, __doc__)
