"""Hostile recordings among good ones: each is used or rejected with a reason, and the good ones lose nothing."""

import random
from functools import cache
from pathlib import Path
from tempfile import mkdtemp

import numpy as np

from tests.campaign.clips import clip
from tests.campaign.results import Result, refused, used
from tests.campaign.scripts import run_script
from visualspeech.corpora.adapters import list_utterances
from visualspeech.corpora.aligning import AlignmentSources
from visualspeech.corpora.check_settings import CheckSettings
from visualspeech.corpora.demo.recording import record
from visualspeech.corpora.findings import REJECT, Finding, read_findings
from visualspeech.corpora.records import Utterance
from visualspeech.corpora.table import write_utterances
from visualspeech.storage.arrays import ArrayReader

GOOD = {"good1": "We may go now.", "good2": "A big map."}
_AT_A_TIME = 250  # clips of one corpus


def run(folder: Path, seed: int, count: int) -> list[Result]:
    """Results of hostile recordings, some hundred at a time in one corpus of one shard."""
    results = []
    for first in range(0, count, _AT_A_TIME):
        part = folder / f"media{first}"
        results += _corpus(part, random.Random(f"media {seed} {first}"), min(_AT_A_TIME, count - first))
    return results


@cache
def good_recordings() -> tuple[Path, ...]:
    """Two short recordings of the demo speaker, made once per process, each with its transcript."""
    folder = Path(mkdtemp(prefix="visualspeech.campaign."))
    for name, text in GOOD.items():
        record(Utterance(name, "demo", "", text), folder / f"{name}.mp4")
    return tuple(folder / f"{name}.mp4" for name in GOOD)


def _corpus(folder: Path, rng: random.Random, count: int) -> list[Result]:
    root = folder / "clips"
    root.mkdir(parents=True)
    for path in good_recordings():
        for one in (path, path.with_suffix(".txt")):
            (root / one.name).write_bytes(one.read_bytes())
    clips = {}
    for number in range(count):
        path, what = clip(number, rng.choice(good_recordings()), root, rng)
        clips[path.stem] = path.name, what
    stages = process(root, folder)
    if stages.wrong:
        return [Result(f"a corpus of {count} hostile recordings", False, "", stages.wrong)]
    results = [_result(name, *clips[name], stages) for name in clips]
    return results + [Result(name, False, "", stages.lost(name)) for name in GOOD]


class Stages:
    """What the recording stages made of a corpus.

    Parameters
    ----------
    listed : ids of the utterances that the adapter lists
    findings : of all stages
    done : ids that went through all stages
    wrong : why the corpus as a whole was stopped; empty if it was not
    """

    def __init__(self, folder: Path, listed: set[str], wrong: str) -> None:
        self.folder, self.listed, self.wrong = folder, listed, wrong
        self.findings: list[Finding] = []
        self.done: set[str] = set()

    def lost(self, name: str) -> str:
        """What is wrong with a good recording; empty if nothing is."""
        if name not in self.done:
            return f"the good recording {name} was lost"
        with ArrayReader(self.folder / "audio.h5") as audio:
            return "" if np.any(audio.array(name, "samples")) else f"the sound of {name} was lost"


def process(root: Path, folder: Path) -> Stages:
    """Check, align and track the recordings below ``root`` with the scripts of the workflow."""
    utterances = list_utterances({"name": "campaign", "adapter": "folder", "root": str(root)})
    files = {name: str(folder / name) for name in ("utterances.tsv", "audio.h5", "alignment.tsv", "landmarks.h5")}
    found = {stage: str(folder / f"{stage}.findings.tsv") for stage in ("check", "align", "track")}
    write_utterances(files["utterances.tsv"], (vars(one) for one in utterances))
    source = {"utterances": files["utterances.tsv"], "audio": files["audio.h5"]}
    checked = {"findings": found["check"], "digests": str(folder / "digests.tsv"), "audio": files["audio.h5"]}
    told = {"settings": {}, "text": True, "sources": AlignmentSources().plain()}
    jobs = [
        ("check_recordings", source, checked, {"settings": vars(CheckSettings()), "text": True, "dictionary": {}}),
        ("align_speech", source, {"table": files["alignment.tsv"], "findings": found["align"]}, told),
        (
            "track_landmarks",
            source,
            {"landmarks": files["landmarks.h5"], "findings": found["track"]},
            {"landmarks": {}, "screening": {}, "folder": ""},
        ),
    ]
    stages = Stages(folder, {one.id for one in utterances}, "")
    for name, given, output, params in jobs:
        done = run_script(name, folder, given, output, params)
        if done.status or "Traceback" in done.said:
            stages.wrong = f"{name} ended with status {done.status}: {done.said[-500:]}"
            return stages
    stages.findings = read_findings(*found.values())
    with ArrayReader(files["landmarks.h5"]) as landmarks:
        rejected = {one.id for one in stages.findings if one.level == REJECT}
        stages.done = set(landmarks.ids) - rejected
    return stages


def _result(name: str, file: str, what: str, stages: Stages) -> Result:
    if name not in stages.listed:
        return used(f"{file}: {what}", wrong="the recording is not listed")
    rejections = [one for one in stages.findings if one.id == name and one.level == REJECT]
    if not rejections:
        return used(f"{file}: {what}", wrong="" if name in stages.done else "neither used nor rejected")
    first = rejections[0]
    said = f"{first.file}: {first.finding}. {first.remedy}"
    result = refused(f"{file}: {what}", said, [file])
    return result if first.remedy else Result(result.case, True, said, result.wrong or "no remedy is given")
