"""The HMMs that are rows of the result tables, each made from the one before it."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from visualspeech.errors import DataError, SettingError
from visualspeech.models.hmm.mge import refine
from visualspeech.models.hmm.model import Hmm, HmmSettings
from visualspeech.models.hmm.segments import Example
from visualspeech.models.hmm.training import fit_monophones, fit_tied
from visualspeech.models.names import HMMS


def train_variant(
    name: str,
    start: Hmm | None,
    training: Sequence[Example],
    validation: Sequence[Example],
    phones: Sequence[str],
    settings: HmmSettings,
    aam: str = "",
) -> Hmm:
    """One of :data:`visualspeech.models.names.HMMS`.

    Parameters
    ----------
    start : the variant before it; None for ``hmm_monophone``
    training, validation : utterances as (:class:`PhoneTrack`, values (T, N), their rate in Hz)
    phones : inventory
    settings : of all variants
    aam : digest of the appearance model

    Raises
    ------
    SettingError
        The name is unknown.
    DataError
        There is no utterance to learn from, or the variant before is not given.
    """
    if name not in HMMS:
        raise SettingError(f"`hmm.variants`: {name!r} is unknown. Known: {', '.join(HMMS)}.")
    if name == HMMS[0]:
        return fit_monophones(training, phones, settings, aam)
    if start is None:
        raise DataError(f"{name} is made from {HMMS[HMMS.index(name) - 1]}, which is not given.")
    start = replace(start, settings=settings)
    steps: dict[str, Callable[[], Hmm]] = {
        "hmm_tied": lambda: fit_tied(start, training),
        "hmm_mge": lambda: refine(start, training, validation),
    }
    return steps[name]()
