"""The measures of the table across systems, from :func:`visualspeech.evaluation.lip_statistics.lip_statistics`.

Formulae: docs/scoring.md, "Across systems".
"""

import numpy as np

from visualspeech.evaluation.articulation import MAX_LAG, PERCENTILE, TARGETS, opening_correlation, opening_lag
from visualspeech.evaluation.metrics import Metric, concordance, quotient
from visualspeech.evaluation.tracked import BILABIAL


def root_ratio(sums: np.ndarray) -> np.ndarray:
    """Square root of the first sum over the second, (..., 2) -> (...); NaN where the second is 0."""
    return np.sqrt(quotient(sums))


_CLOSED = (
    f"at most the {PERCENTILE}th percentile of the least openings in {TARGETS[BILABIAL]} of the recorded training "
    "utterances"
)

ACROSS: dict[str, Metric] = {
    metric.name: metric
    for metric in (
        Metric(
            "lip_distance",
            "distance",
            "mean over frames and lip points of the Euclidean distance between predicted and recorded point, in % of "
            "the distance of the outer corners of the speaker's eyes",
            "low",
            ("lip_distance_sum", "frames"),
            unit="%",
        ),
        Metric(
            "opening_corr",
            "CORR",
            "correlation over all frames of the opening of the mouth, predicted and recorded",
            "high",
            ("opening",),
            opening_correlation,
        ),
        Metric(
            "opening_ccc",
            "CCC",
            "concordance correlation over all frames of the opening of the mouth",
            "high",
            ("opening",),
            concordance,
        ),
        Metric(
            "width_corr",
            "CORR",
            "correlation over all frames of the width of the mouth, predicted and recorded",
            "high",
            ("width",),
            opening_correlation,
        ),
        Metric(
            "width_ccc",
            "CCC",
            "concordance correlation over all frames of the width of the mouth",
            "high",
            ("width",),
            concordance,
        ),
        Metric(
            "closure",
            f"on {TARGETS[BILABIAL]}",
            f"share of the occurrences of {TARGETS[BILABIAL]} in which the least opening is {_CLOSED}",
            "high",
            ("closed", "closures"),
        ),
        Metric(
            "silence",
            "in silence",
            "share of the frames of silence in which the opening is at most this threshold",
            "high",
            ("silent_closed", "silent_frames"),
        ),
        Metric(
            "jerk",
            "jerk",
            "root mean square third difference over frames of the lip points: predicted divided by recorded (below 1: "
            "smoother than the recording, noise of the tracker included)",
            "one",
            ("jerk",),
            root_ratio,
        ),
        Metric(
            "lag",
            "lag",
            "time by which the predicted opening comes after the recorded one, at the maximum of their "
            f"cross-correlation within {1000 * MAX_LAG:g} ms",
            "zero",
            ("lag",),
            opening_lag,
            unit="ms",
        ),
        Metric(
            "frames_per_second",
            "speed",
            "frames of the camera predicted per second of one processor core, from input features to parameters of the "
            "visual coding; measured on the machine of this run, so it differs between runs",
            "high",
            ("frames", "seconds"),
            unit="frames/s",
        ),
        Metric(
            "parameters",
            "parameters",
            "number of weights and biases of a network, of means, variances, durations and transition probabilities of "
            "an HMM; of all members of a model that is made of others",
            "low",
            ("parameters", "utterances"),
        ),
    )
}
#: What a prediction costs.
COSTS = ("frames_per_second", "parameters")
#: Decimals that differ from those of the table.
DIGITS = {"lag": 1, "frames_per_second": 0, "parameters": 0}
