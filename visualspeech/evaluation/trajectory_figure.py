"""The figure of one parameter of a test utterance, as models with different inputs predict it."""

from collections.abc import Mapping, Sequence

from visualspeech.corpora.records import Utterance
from visualspeech.corpora.table import of_split
from visualspeech.errors import DataError
from visualspeech.evaluation import plots
from visualspeech.speech.alignment import alignments_of
from visualspeech.storage.arrays import ArrayCollection, ArrayReader


def parameter_figure(
    utterances: Sequence[Utterance],
    wanted: str,
    targets: ArrayCollection,
    predictions: Mapping[str, str],
    alignments: Sequence[str],
    number: int,
) -> bytes:
    """The PNG of :func:`visualspeech.evaluation.plots.parameter` for one test utterance.

    Parameters
    ----------
    utterances : of all splits
    wanted : id of the utterance; empty: the first test utterance
    targets : opened; the recorded ``appearance``
    predictions : title of a model -> path of its predictions
    alignments : shards of the alignment
    number : of the parameter, from 1

    Raises
    ------
    DataError
        There is no such test utterance, or no such parameter.
    """
    test = {one.id: one for one in of_split(utterances, "test")}
    shown = test.get(wanted or next(iter(test), ""))
    if shown is None:
        known = ", ".join(list(test)[:4]) + (", ..." if len(test) > 4 else "")
        raise DataError(f"`trajectories.utterance: {wanted}` is no test utterance. Test utterances: {known or 'none'}.")
    predicted = {}
    for title, path in predictions.items():
        with ArrayReader(path) as arrays:
            predicted[title] = arrays.array(shown.id, "appearance")
    spoken = alignments_of(alignments, [shown.id])[shown.id]
    return plots.parameter(
        targets.array(shown.id, "appearance"),
        predicted,
        targets.rate(shown.id),
        [(phone.label, phone.start, phone.end) for phone in spoken.phones],
        number,
        title=f"{shown.id}: {shown.transcript}",
    )
