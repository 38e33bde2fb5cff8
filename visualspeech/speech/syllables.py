"""Syllables of pronounced words and their stress.

The dictionary of the acoustic model has no stress marks. Stress is taken from the letter-to-sound rules of the
synthesiser and mapped to the aligned pronunciation.
"""

from collections.abc import Sequence

from visualspeech.speech.phones import CLASSES

VOWELS = CLASSES["vowel"] | CLASSES["diphthong"]

#: Consonant clusters that an English syllable may begin with, apart from single consonants other than ng.
ONSETS = frozenset(
    tuple(cluster.split())
    for cluster in (
        "p l, p r, p y, b l, b r, b y, t r, t w, d r, d w, k l, k r, k w, k y, g l, g r, g w, f l, f r, f y, v y, m y, "
        "n y, hh y, th r, th w, sh r, s p, s t, s k, s f, s m, s n, s l, s w, s p l, s p r, s p y, s t r, s k r, "
        "s k w, s k y"
    ).split(", ")
)


def syllables(phones: Sequence[str]) -> list[range]:
    """Indices of the phones of each syllable of one word, by the maximal-onset principle.

    Between two vowels, the longest sequence of consonants that may begin an English word belongs to the second
    syllable. A word without a vowel is one syllable.
    """
    vowels = [index for index, phone in enumerate(phones) if phone in VOWELS]
    starts = [0]
    for before, vowel in zip(vowels, vowels[1:], strict=False):
        start = vowel
        while start - 1 > before and _may_begin(phones[start - 1 : vowel]):
            start -= 1
        starts.append(start)
    return [range(start, end) for start, end in zip(starts, [*starts[1:], len(phones)], strict=True) if end > start]


def _may_begin(cluster: Sequence[str]) -> bool:
    return cluster[0] != "ng" if len(cluster) == 1 else tuple(cluster) in ONSETS


def stress_of_syllables(phones: Sequence[str], stresses: Sequence[int]) -> list[int]:
    """Stress of each syllable of a word: 0 none, 1 secondary, 2 primary.

    If the pronunciation has another number of syllables than ``stresses``, each syllable takes the stress of the one
    nearest in relative position; a single syllable takes the strongest.

    Parameters
    ----------
    phones : as pronounced
    stresses : of the vowels of the word, from letter-to-sound rules
    """
    count = len(syllables(phones))
    if not stresses:
        return [0] * count
    if count == 1:
        return [max(stresses)]
    last = len(stresses) - 1
    return [stresses[int(position * last / (count - 1) + 0.5)] for position in range(count)]
