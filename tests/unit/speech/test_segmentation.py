"""Speech and pauses by the level of a recording."""

import numpy as np
import pytest

from visualspeech.errors import RejectedUtterance
from visualspeech.speech.alignment import read_alignments, silent_frames, to_table
from visualspeech.speech.segmentation import MIN_PAUSE, SPEECH, alignment_of, pauses, segmented
from visualspeech.speech.sound import RATE, Sound
from visualspeech.storage.tables import write_table


def recording(*parts, floor=20, seed=0):
    """Noise of a room with louder parts: (seconds, size) each."""
    random = np.random.default_rng(seed)
    sizes = np.concatenate([np.full(round(seconds * RATE), size) for seconds, size in parts])
    return np.round(random.normal(0, 1, len(sizes)) * np.hypot(sizes, floor)).astype(np.int16)


@pytest.mark.parametrize("gain", [1.0, 0.1])
def test_pauses_are_where_it_is_quiet(gain):
    samples = recording((0.5, 0), (1.0, 3000), (0.4, 0), (0.7, 2000), (0.08, 0), (0.6, 2500), (0.9, 0))
    found = pauses(Sound((samples * gain).astype(np.int16)))
    # The short gap at 2.6 s is that of a stop.
    assert np.allclose(found, [(0, 0.5), (1.5, 1.9), (3.28, 4.18)], atol=0.03)
    assert found[0][0] == 0 and found[-1][1] == len(samples) / RATE


def test_a_short_pause_at_an_end_is_one():
    found = pauses(Sound(recording((0.1, 0), (1.0, 3000), (0.3, 0), (1.0, 3000), (0.12, 0))))
    assert np.allclose(found, [(0, 0.1), (1.1, 1.4), (2.4, 2.52)], atol=0.03) and MIN_PAUSE > 0.12


@pytest.mark.parametrize(
    ("samples", "said"),
    [
        (np.zeros(0, np.int16), "only 0.000 s of sound"),
        (recording((0.001, 3000)), "only 0.001 s of sound"),
        (recording((5, 3000)), "no speech"),  # steady noise
        (recording((5, 0)), "no speech"),
        (np.zeros(32_000, np.int16), "no speech"),
        (np.full(32_000, 12_000, np.int16), "no speech"),
    ],
)
def test_what_is_no_speech_is_rejected(samples, said):
    with pytest.raises(RejectedUtterance, match=said):
        segmented(samples)


def test_an_alignment_of_speech_and_pauses(tmp_path):
    samples = recording((0.5, 0), (1.0, 3000), (0.4, 0), (1.1, 3000))
    found = segmented(samples, "Not used.")
    assert [one.label for one in found.phones] == ["sil", SPEECH, "sil", SPEECH]
    assert found.phones[0].start == 0 and found.duration == len(samples) / RATE
    assert [one.label for one in found.states] == ["1", "2", "3"] * 4
    frames = silent_frames(found, 75, 25.0)
    expected = [time < 0.5 or 1.5 <= time < 1.9 for time in (np.arange(75) + 0.5) / 25]
    assert (frames != expected).sum() <= 2
    write_table(tmp_path / "table.tsv", to_table({"a": found}))  # the reader checks that no tier has gaps
    again = read_alignments(tmp_path / "table.tsv")["a"]
    assert [one.label for one in again.phones] == [one.label for one in found.phones]


@pytest.mark.parametrize(
    ("begin", "end", "expected"),
    [
        (0.0, 4.0, [("sil", 0, 1), (SPEECH, 1, 2), ("sil", 2, 3), (SPEECH, 3, 4)]),
        (0.5, 2.5, [("sil", 0, 0.5), (SPEECH, 0.5, 1.5), ("sil", 1.5, 2)]),
        (1.0, 2.0, [(SPEECH, 0, 1)]),
        (2.0, 3.0, [("sil", 0, 1)]),
        (3.5, 4.0, [(SPEECH, 0, 0.5)]),
    ],
)
def test_a_piece_has_its_part_of_the_pauses(begin, end, expected):
    found = alignment_of([(0.0, 1.0), (2.0, 3.0)], begin, end)
    assert [(one.label, one.start, one.end) for one in found.phones] == expected
