"""A system's section of the report from the files of a run."""

import numpy as np
import pandas

from tests.unit.evaluation.examples import stack
from tests.unit.speech.alignments import even_alignment
from visualspeech.corpora.records import Utterance
from visualspeech.corpora.table import write_accepted
from visualspeech.evaluation import gathering, plots
from visualspeech.evaluation.forms import to_html, to_html_page
from visualspeech.evaluation.layout import Cell, Row, Table
from visualspeech.speech.alignment import to_table
from visualspeech.storage.arrays import ArrayCollection, ArrayWriter
from visualspeech.storage.files import write_text
from visualspeech.storage.tables import write_table

UTTERANCES = [Utterance(name, "one", f"{name}.mp4", f"words of {name}", split)
              for name, split in (("a", "train"), ("b", "validation"), ("c", "test"), ("d", "test"))]  # fmt: skip
TABLE = Table("Objective measures", ("x",), (Row("FBB-64", (Cell("1.0"),)),))


def arrays(path, name, frames, ids="abcd"):
    with ArrayWriter(path) as out:
        for one in ids:
            out.add(one, {name: np.random.default_rng(1).normal(size=(frames, 3))}, 25.0)
    return str(path)


def given(folder):
    """Files of a run below a folder, as the script of the report gets them."""
    write_text(folder / "objective.html", to_html_page([TABLE], "Objective measures"))
    rows = [stack("FBB-64", "FBB", 64), stack("FFF-64", "FFF", 64)]
    for row in rows:
        curve = pandas.DataFrame({"epoch": [1, 2], "train": [2.0, 1.0], "validation": [2.0, 1.5]})
        write_table(folder / f"{row.name}.tsv", curve)
    spoken = even_alignment([("a", ["ah"])], 0.4)
    write_table(folder / "alignment.tsv", to_table({"c": spoken, "d": spoken}))
    (folder / "figure.png").write_bytes(b"a picture")
    (folder / "fan2015" / "videos").mkdir(parents=True)
    (folder / "fan2015" / "videos" / "c.mp4").touch()
    return {
        "name": "fan2015",
        "title": "Fan 2015",
        "facts": [["rate", "25 Hz"]],
        "tables": [str(folder / "objective.html")],
        "utterances": str(folder / "utterances.tsv"),
        "targets": [arrays(folder / "targets.h5", "appearance", 10)],
        "rows": [row.plain() for row in rows],
        "curves": [str(folder / f"{row.name}.tsv") for row in rows],
        "coding": "",
        "visemes": [],
        "reference": "",
        "predictions": arrays(folder / "predictions.h5", "appearance", 10, "bcd"),
        "model": "FBB-64",
        "videos": str(folder / "fan2015" / "videos"),
        "figures": [str(folder / "figure.png")],
        "captions": ["Parameter 5"],
    }


def section(folder, **changes):
    plain = given(folder) | changes
    write_accepted(plain["utterances"], UTTERANCES, {one.id: one.split for one in UTTERANCES})
    return gathering.system_section(plain, [str(folder / "alignment.tsv")], str(folder / "report.html"))


def test_everything_that_the_files_hold(tmp_path):
    made = section(tmp_path)
    assert (made.name, made.title) == ("fan2015", "Fan 2015")
    assert made.facts == (("rate", "25 Hz"), ("frames", "10 training, 10 validation, 20 test"))
    assert made.tables == (to_html([TABLE]),) and made.modes == ()
    assert [picture.caption for picture in made.learning_curves] == ["Learning curves of FBB-64, FFF-64"]
    assert [picture.caption.partition(",")[0] for picture in made.trajectories] == [
        f"Parameters of the visual coding of {one}" for one in "cd"
    ]
    assert [(picture.png, picture.caption) for picture in made.figures] == [(b"a picture", "Parameter 5")]
    (video,) = made.videos
    assert (video.path, video.transcript, video.model) == ("fan2015/videos/c.mp4", "words of c", "FBB-64")


def test_what_is_not_given_is_left_out(tmp_path):
    made = section(tmp_path, tables=[], rows=[], curves=[], predictions="", videos="", figures=[], captions=[])
    assert not (made.tables or made.learning_curves or made.trajectories or made.videos or made.figures)


def test_the_origin_of_a_report(monkeypatch):
    monkeypatch.setenv("VISUALSPEECH_COMMAND", "snakemake --cores 2 all")
    monkeypatch.setattr(gathering, "commit", lambda: "abc1234")
    found = gathering.origin()
    assert (found["commit"], found["command"]) == ("abc1234", "snakemake --cores 2 all")
    assert found["date"].count("-") == 2


def test_sizes_and_timings_of_the_corpus(tmp_path):
    assert gathering.split_sizes(UTTERANCES) == {"train": 1, "validation": 1, "test": 2}
    path = tmp_path / "benchmarks" / "track_landmarks" / "0.tsv"
    write_text(path, "s\tmax_rss\n2.0\t100\n")
    (timing,) = gathering.stage_timings([str(path)], [arrays(tmp_path / "landmarks.h5", "points", 25)])
    assert timing.frames_per_second == 50
    assert gathering.stage_timings([], []) == () and "visualspeech" in gathering.versions()


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
        pictures = gathering.trajectory_pictures(utterances[1:], features, predictions, "net", paths)
    assert [title for *_, title in shown] == ["de: de", "fg: fg"] and len(pictures) == 2
    assert [[label for label, _, _ in phones] for _, _, _, phones, _ in shown] == [["sil", "d", "e"], ["sil", "f", "g"]]
    assert list(shown[0][1]) == ["net"] and shown[0][3][1][1:] == (0.2, 0.4)
