import numpy as np
import pytest

from visualspeech.errors import DataError
from visualspeech.models.hmm.examples import TimedExamples, read_tracks
from visualspeech.speech.alignment import to_table
from visualspeech.speech.spoken import timed
from visualspeech.storage import ArrayCollection, ArrayWriter, write_table


def test_phones_and_appearance_meet(tmp_path):
    aligned = {"one": timed([("sil", 0.0, 0.1), ("aa", 0.1, 0.2)]), "two": timed([("aa", 0.0, 0.1)])}
    write_table(tmp_path / "0.tsv", to_table(aligned))
    with ArrayWriter(tmp_path / "0.h5") as out:
        for name, frames in (("one", 5), ("two", 3)):
            streams = {"labels": np.zeros((frames, 4), np.int16), "appearance": np.full((frames, 2), frames, "f4")}
            out.add(name, streams, 25.0)
    tracks = read_tracks([tmp_path / "0.tsv"], ["sil", "aa"])
    with ArrayCollection([tmp_path / "0.h5"]) as features:
        examples = TimedExamples(features, ["two", "one"], tracks)
        assert [len(values) for _, values, _ in (examples[0], examples[1])] == [3, 5]
        assert examples[1][0].contexts.tolist() == [[0, 0, 1], [0, 1, 0]]
        assert examples[0][2] == 25.0 and len(examples) == 2
    assert read_tracks([tmp_path / "0.tsv"], ["sil", "aa"], 2, 2)["two"].contexts.tolist() == [[0, 0, 1, 0, 0]]
    with pytest.raises(DataError, match="aa"):
        read_tracks([tmp_path / "0.tsv"], ["sil"])
