"""Export of alignments to other programs: Praat TextGrid, HTK and HTS label files."""

from collections.abc import Sequence
from pathlib import Path

from visualspeech.errors import SettingError
from visualspeech.speech.alignment import TIERS, Alignment, Segment
from visualspeech.speech.phones import SILENCE
from visualspeech.storage.files import replacing, write_text

TICKS = 10_000_000  # per second; HTK counts time in units of 100 ns
_TIER_NAMES = {"word": "words", "phone": "phones", "state": "states"}


def write_textgrid(path: str | Path, alignment: Alignment) -> None:
    """Write the tiers words, phones and states as a Praat TextGrid (long form), pauses as "sil"."""
    from praatio import textgrid
    from praatio.utilities.constants import Interval

    grid = textgrid.Textgrid()
    for tier in TIERS:
        intervals = [Interval(one.start, one.end, one.label) for one in alignment.tier(tier)]
        grid.addTier(textgrid.IntervalTier(_TIER_NAMES[tier], intervals, 0, alignment.duration))
    with replacing(path) as temporary:
        grid.save(str(temporary), format="long_textgrid", includeBlankSpaces=True)


def write_htk_labels(path: str | Path, alignment: Alignment, tier: str = "phone") -> None:
    """Write one tier as an HTK label file: ``start end label`` per line, in units of 100 ns.

    Raises
    ------
    SettingError
        The tier is not one of word, phone, state.
    """
    if tier not in TIERS:
        raise SettingError(f"an alignment has no tier {tier!r}; give one of {', '.join(TIERS)}.")
    write_text(path, _lines((one.start, one.end, one.label) for one in alignment.tier(tier)))


def write_hts_labels(path: str | Path, alignment: Alignment) -> None:
    """Write the states as an HTS label file: ``start end left-phone+right[state]`` per line.

    The first state of a phone also carries the triphone, and the first state of a word the word. States are numbered
    from 2, as in HTK; phones outside the utterance are "sil".
    """
    phones = alignment.phones
    labels = [one.label for one in phones]
    around = [SILENCE, *labels, SILENCE]
    rows, previous = [], -1
    for state in alignment.states:
        at = state.parent
        name = f"{around[at]}-{around[at + 1]}+{around[at + 2]}[{int(state.label) + 1}]"
        if at != previous:
            name += f" {name.partition('[')[0]}"
            if at == 0 or phones[at].parent != phones[at - 1].parent:
                name += f" {alignment.words[phones[at].parent].label}"
        previous = at
        rows.append((state.start, state.end, name))
    write_text(path, _lines(rows))


def read_htk_labels(path: str | Path) -> tuple[Segment, ...]:
    """Segments of an HTK or HTS label file (the first field after the times is the label)."""
    rows = (line.split() for line in Path(path).read_text(encoding="utf-8").splitlines() if line.strip())
    return tuple(Segment(fields[2], int(fields[0]) / TICKS, int(fields[1]) / TICKS) for fields in rows)


def _lines(rows: Sequence[tuple[float, float, str]]) -> str:
    return "".join(f"{round(start * TICKS)} {round(end * TICKS)} {label}\n" for start, end, label in rows)
