"""Measures of the user's own: a function of the prediction and the truth of one utterance, which gives a number.

The figure of a corpus is the mean over utterances of what the function gives for each, so that intervals, tests and
tables treat it as any other measure. Tables need its description alone, not the function
(:mod:`visualspeech.evaluation.own_functions`).
"""

from collections.abc import Mapping

from visualspeech.evaluation.metrics import METRICS, Metric

#: What stands between module and function in the name of a measure.
OWN_MARK = ":"
#: What a function may ask for by name, beside prediction and truth.
GIVEN = {
    "predicted_points": "points decoded from the prediction",
    "true_points": "points of the recorded face",
    "rate": "frames per second",
}


def own_metric(name: str, described: Mapping) -> Metric:
    """The measure of that name, from its description (:func:`visualspeech.planning.own_metrics.described`)."""
    return Metric(
        name, described["title"], described["definition"], described["best"], (f"{name}_sum", "utterances"),
        unit=described["unit"],
    )  # fmt: skip


def register(own: Mapping[str, Mapping]) -> None:
    """Make measures of the user's own known to this process, by their names in the settings."""
    METRICS.update({name: own_metric(name, described) for name, described in own.items()})
