"""What explicit durations and wide contexts are worth: tied-state HMMs and HSMMs, of triphones and of full contexts.

Run: python -m benchmarks.hmm_durations RESULTS SYSTEM [HZ [KEY=VALUE ...]]

RESULTS is the folder of a finished run, for example results/grid, SYSTEM a system that was run on it, whose targets are
resampled to HZ, by default 100. The blocks are computed from the run's alignments. KEY=VALUE are settings of the HMMs;
min_frames counts frames at HZ. Prints for each of the four, on validation and on test utterances, centred
RMSE(appearance) and CORR (Eq. 18 and 19); number of Gaussians; processor seconds of training.
"""

import time
from collections.abc import Sequence
from pathlib import Path

from benchmarks.command import run_main
from benchmarks.hmm import value_of
from benchmarks.runs import VARIANTS, CorpusRun, SystemRun, fit_hmm, rmse_and_corr
from visualspeech.features.blocks.base import Block, Source, block_class
from visualspeech.features.contexts import read_phones
from visualspeech.features.examples import Example
from visualspeech.features.targets import target_streams
from visualspeech.fields import with_defaults
from visualspeech.models.hmm.model import HmmSettings
from visualspeech.speech.substitutes import in_phones


def main(results: Path, system: str, rate: float = 100.0, *changes: str) -> None:
    run, given = SystemRun(CorpusRun(results), system), dict(change.split("=") for change in changes)
    given = {key: value_of(text) for key, text in given.items()}
    phones = read_phones(results / "phones.tsv")
    for kind in ("phone_track", "full_context"):
        cls = block_class(kind)
        block = cls.fit(with_defaults(cls.settings, {}), phones, ())
        training, validation, test = (
            _examples(run, split, block, phones, rate) for split in ("train", "validation", "test")
        )
        for durations in ("geometric", "gaussian"):
            begin, found = time.process_time(), None
            for variant in VARIANTS[:2]:
                settings = HmmSettings(**{**given, "variant": variant, "durations": durations})
                found = fit_hmm(settings, {kind: block}, training, validation, found)
            seconds = time.process_time() - begin
            figures = [rmse_and_corr(found, part, centred=True) for part in (validation, test)]
            shown = ", ".join(f"{rmse:.3f} / {corr:.4f}" for rmse, corr in figures)
            print(f"{kind}, {durations}: {shown}, {found.hmm.tying.gaussians} Gaussians, {seconds:.1f} s", flush=True)


def _examples(run: SystemRun, split: str, block: Block, phones: Sequence[str], rate: float) -> list[Example]:
    """The utterances of a split at a rate, with the streams of a block."""
    found = []
    with run.targets() as targets:
        for name in run.corpus.ids(split):
            if name in targets:
                recorded = {"appearance": targets.array(name, "appearance")}
                streams, own = target_streams(recorded, targets.rate(name), rate)
                target = streams["appearance"]
                source = Source(len(target), own, in_phones(run.corpus.alignments[name], phones)[0])
                found.append(Example((next(iter(block.encode([source]))),), target, own))
    return found


if __name__ == "__main__":
    run_main(main, __doc__)
