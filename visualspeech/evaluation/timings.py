"""Cost of the stages of a run: seconds, memory, and frames per second."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np


@dataclass(frozen=True)
class StageTiming:
    """Cost of one stage, over all its jobs.

    Parameters
    ----------
    stage : name
    jobs : number of jobs
    seconds : wall-clock seconds, summed over all jobs, also over parallel ones
    longest : seconds of the longest job
    memory : largest resident set of a job in MB; NaN if all jobs were too short to be measured
    frames : number of frames processed; 0 for stages that do not process frames
    """

    stage: str
    jobs: int
    seconds: float
    longest: float
    memory: float
    frames: int = 0

    @property
    def frames_per_second(self) -> float:
        """Frames per second of one job; NaN for stages that do not process frames."""
        return self.frames / self.seconds if self.frames and self.seconds > 0 else float("nan")


#: Stages of a run for people, and the rules of each; other rules are stages by themselves.
STAGES = {
    "Demo corpus": ("record_demo",),
    "Check of recordings": ("check_recordings",),
    "Alignment": ("align_speech", "export_alignment"),
    "Faces": ("track_landmarks", "fit_head", "normalise_pose", "read_motion"),
    "Visual codings": ("fit_reference", "fit_aam", "sample_textures", "fit_faces", "encode_appearance", "fit_markers",
                       "encode_markers"),
    "Training": ("train_model",),
    "Prediction": ("predict_model",),
    "Videos": ("render_videos", "render_markers"),
}  # fmt: skip
#: Name of the folders that hold the benchmark files of jobs.
FOLDER = "benchmarks"


def stage_of(path: str | Path) -> str:
    """The stage of a benchmark file ``benchmarks/<stage>.tsv`` or ``benchmarks/<stage>/.../<job>.tsv``."""
    parts = Path(path).with_suffix("").parts
    last = max((index for index, name in enumerate(parts[:-1]) if name == FOLDER), default=len(parts) - 2)
    return parts[last + 1]


def read_timings(paths: Iterable[str | Path], frames: Mapping[str, int] | None = None) -> tuple[StageTiming, ...]:
    """Cost of every stage, in the order in which the stages ended.

    Parameters
    ----------
    paths : benchmark files, one per job, with the columns ``s`` (wall-clock seconds) and ``max_rss`` (MB), of which the
        last line is read. Missing and incomplete files are left out
    frames : stage -> number of frames processed
    """
    stages: dict[str, list[Path]] = {}
    for path in map(Path, paths):
        stages.setdefault(stage_of(path), []).append(path)
    found = []
    for stage, files in stages.items():
        measured = [(path, cost) for path, cost in ((path, _job(path)) for path in files) if cost is not None]
        if measured:
            ended = max(path.stat().st_mtime for path, _ in measured)
            found.append((ended, _stage(stage, [cost for _, cost in measured], (frames or {}).get(stage, 0))))
    return tuple(timing for _, timing in sorted(found, key=lambda one: (one[0], one[1].stage)))


def by_stage(timings: Iterable[StageTiming]) -> tuple[StageTiming, ...]:
    """The cost of whole stages (:data:`STAGES`), in that order, from that of their rules.

    Frames are those of the rule that processes most of them.
    """
    groups: dict[str, list[StageTiming]] = {name: [] for name in STAGES}
    names = {rule: name for name, rules in STAGES.items() for rule in rules}
    for timing in timings:
        groups.setdefault(names.get(timing.stage, timing.stage), []).append(timing)
    return tuple(
        StageTiming(
            name,
            sum(one.jobs for one in group),
            sum(one.seconds for one in group),
            max(one.longest for one in group),
            float(np.fmax.reduce([one.memory for one in group])),
            max(one.frames for one in group),
        )
        for name, group in groups.items()
        if group
    )


def _stage(name: str, jobs: list[tuple[float, float]], frames: int) -> StageTiming:
    seconds, memory = np.array(jobs).T
    measured = memory[np.isfinite(memory)]
    largest = float(measured.max()) if len(measured) else float("nan")
    return StageTiming(name, len(jobs), float(seconds.sum()), float(seconds.max()), largest, frames)


def _job(path: Path) -> tuple[float, float] | None:
    """Seconds and MB of one job; None if its table is missing or incomplete, as a killed job may leave it."""
    try:
        header, *lines = [line.split("\t") for line in path.read_text(encoding="utf-8").splitlines() if line.strip()]
        values = dict(zip(header, lines[-1], strict=True))
        return float(values["s"]), _number(values.get("max_rss", ""))
    except (OSError, ValueError, KeyError, IndexError):
        return None


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return float("nan")
