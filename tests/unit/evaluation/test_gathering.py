"""What the report shows of a run's files."""

import numpy as np

from tests.unit.speech.alignments import even_alignment
from visualspeech.corpora.records import Utterance
from visualspeech.evaluation import gathering, plots
from visualspeech.speech.alignment import to_table
from visualspeech.storage import ArrayCollection, ArrayWriter, write_table


def test_trajectories_carry_the_phones_of_their_own_utterance(tmp_path, monkeypatch):
    aligned = {name: even_alignment([("sil", ["sil"]), (name, list(name))], 0.2) for name in ("ab", "de", "fg")}
    write_table(tmp_path / "0.tsv", to_table({name: aligned[name] for name in ("ab", "fg")}))
    write_table(tmp_path / "1.tsv", to_table({"de": aligned["de"]}))
    for path in (tmp_path / "0.h5", tmp_path / "net" / "predictions.h5"):
        with ArrayWriter(path) as out:
            for name in aligned:
                out.add(name, {"appearance": np.zeros((15, 3), np.float32)}, 25.0)
    utterances = [Utterance(name, "s", f"{name}.mp4", name, "train" if name == "ab" else "test") for name in aligned]
    shown = []
    monkeypatch.setattr(plots, "trajectories", lambda *given, title: shown.append((*given, title)) or b"png")
    paths = [str(tmp_path / f"{shard}.tsv") for shard in (0, 1)]
    with ArrayCollection([tmp_path / "0.h5"]) as features:
        predictions = str(tmp_path / "net" / "predictions.h5")
        pictures = gathering.trajectory_pictures(utterances, features, predictions, paths, 3)
    assert [title for *_, title in shown] == ["de: de", "fg: fg"] and len(pictures) == 2
    assert [[label for label, _, _ in phones] for _, _, _, phones, _ in shown] == [["sil", "d", "e"], ["sil", "f", "g"]]
    assert list(shown[0][1]) == ["net"] and shown[0][3][1][1:] == (0.2, 0.4)
