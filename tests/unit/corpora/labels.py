"""Alignments of an utterance as files of other programs, for tests of what reads them."""

from visualspeech.speech.given import Interval

#: What is said, and when: words and phones, pauses left out.
WORDS = ((0.2, 0.5, "be"), (0.5, 0.9, "me"))
PHONES = ((0.2, 0.3, "B"), (0.3, 0.5, "IY1"), (0.5, 0.7, "M"), (0.7, 0.9, "IY1"))
SECONDS = 1.2


def write_grid(path, tiers=None, form="long_textgrid", encoding="utf-8", seconds=SECONDS):
    """A TextGrid as praatio, and so the Montreal Forced Aligner, writes it."""
    from praatio import textgrid
    from praatio.utilities.constants import Interval as Entry

    grid = textgrid.Textgrid()
    for name, entries in (tiers or {"words": WORDS, "phones": PHONES}).items():
        grid.addTier(textgrid.IntervalTier(name, [Entry(*one) for one in entries], 0, seconds))
    path.parent.mkdir(parents=True, exist_ok=True)
    grid.save(str(path), format=form, includeBlankSpaces=True)
    path.write_bytes(path.read_text(encoding="utf-8").encode(encoding))
    return path


def intervals(tier):
    """The intervals of a tier of the constants above."""
    return tuple(Interval(*one) for one in tier)


def spoken(intervals):
    """Intervals without the empty ones of pauses."""
    return tuple(one for one in intervals if one.label)
