"""Settings of the evaluation of a viewing test."""

from dataclasses import dataclass

from visualspeech.fields import MAX_SEED, Settings, setting


@dataclass(frozen=True)
class EvaluationSettings(Settings):
    """Who is counted in a viewing test, and how its intervals and tests are computed."""

    section = "study_evaluation.statistics"
    max_failed_attention: int = setting(
        0, "Number of attention items that a participant may fail and still be counted.", minimum=0, maximum=1000
    )
    level: float = setting(0.95, "Confidence level of the intervals, for example 0.95.", above=0, below=1)
    star_level: float = setting(
        0.01, "Family-wise significance level of the stars in the figure of ratings.", above=0, below=1
    )
    samples: int = setting(10_000, "Number of bootstrap samples over participants.", minimum=100, maximum=1_000_000)
    permutations: int = setting(
        10_000, "Number of random draws of the permutation tests over participants.", minimum=100, maximum=1_000_000
    )
    seed: int = setting(0, "Seed of the bootstrap samples and permutations.", minimum=0, maximum=MAX_SEED)
