"""A system's section of the report from the files of a run."""

import numpy as np
import pandas
import pytest

from tests.unit.evaluation.examples import BASELINES, measured, stack, statistics
from tests.unit.evaluation.test_across_systems import lips
from tests.unit.speech.alignments import even_alignment
from visualspeech.corpora.records import Utterance
from visualspeech.corpora.table import write_accepted
from visualspeech.errors import StorageError
from visualspeech.evaluation import gathering, plots
from visualspeech.evaluation.comparisons import compare
from visualspeech.evaluation.forms import all_forms, to_html
from visualspeech.evaluation.layout import Cell, Row, Table
from visualspeech.evaluation.lip_rows import lip_table
from visualspeech.evaluation.report import FileLink
from visualspeech.speech.alignment import to_table
from visualspeech.storage.arrays import ArrayCollection, ArrayWriter
from visualspeech.storage.files import write_text
from visualspeech.storage.tables import write_table

UTTERANCES = [Utterance(name, "one", f"{name}.mp4", f"words of {name}", split)
              for name, split in (("a", "train"), ("b", "validation"), ("c", "test"), ("d", "test"))]  # fmt: skip
TABLE = Table("Objective measures", ("x",), (Row("FBB-64", (Cell("1.0"),)),))
ROWS = [stack("FBB-64", "FBB", 64), stack("FFF-64", "FFF", 64), BASELINES["training_mean"]]


def arrays(path, name, frames, ids="abcd"):
    with ArrayWriter(path) as out:
        for one in ids:
            out.add(one, {name: np.random.default_rng(1).normal(size=(frames, 3))}, 25.0)
    return str(path)


def given(folder):
    """Files of a run below a folder, as the script of the report gets them."""
    texts = all_forms(pandas.DataFrame({"row": ["FBB-64"], "x": [1.0]}), [TABLE], "Objective measures")
    for suffix, text in zip(("tsv", "md", "tex", "html"), texts, strict=True):
        write_text(folder / f"objective.{suffix}", text)
    nets = ROWS[:2]
    for row in nets:
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
        "tables": [[str(folder / f"objective.{suffix}") for suffix in ("tsv", "md", "tex", "html")]],
        "comparisons": [],
        "comparison": {"test": "wilcoxon", "level": 0.05},
        "utterances": str(folder / "utterances.tsv"),
        "targets": [arrays(folder / "targets.h5", "appearance", 10)],
        "rows": [row.plain() for row in ROWS],
        "curves": {row.name: str(folder / f"{row.name}.tsv") for row in nets},
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
    return gathering.system_section(
        plain, "The conclusion.", [str(folder / "alignment.tsv")], str(folder / "report.html")
    )


def test_everything_that_the_files_hold(tmp_path):
    made = section(tmp_path)
    assert (made.name, made.title, made.conclusion) == ("fan2015", "Fan 2015", "The conclusion.")
    assert made.facts == (("rate", "25 Hz"), ("frames", "10 training, 10 validation, 20 test"))
    (table,) = made.tables
    assert table.html == to_html([TABLE]) and made.modes == () and made.comparisons == ()
    assert table.files == tuple(FileLink(label, f"objective.{suffix}") for label, suffix in
                                (("TSV", "tsv"), ("Markdown", "md"), ("TeX", "tex")))  # fmt: skip
    assert [picture.caption for picture in made.learning_curves] == ["Learning curves of FBB-64, FFF-64"]
    assert [picture.caption.partition(",")[0] for picture in made.trajectories] == [
        f"Parameters of the visual coding of {one}" for one in "cd"
    ]
    assert [(picture.png, picture.caption) for picture in made.figures] == [(b"a picture", "Parameter 5")]
    (video,) = made.videos
    assert (video.path, video.transcript, video.model) == ("fan2015/videos/c.mp4", "words of c", "FBB-64")
    assert video.still == b""  # the file is empty


def test_what_is_not_given_is_left_out(tmp_path):
    made = section(tmp_path, tables=[], curves={}, predictions="", videos="", figures=[], captions=[])
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


def test_comparisons_are_one_table_with_its_files(tmp_path):
    rows = measured(
        *((row, statistics(np.arange(1, 9) * size)) for row, size in zip(ROWS, (1.0, 2.0, 3.0), strict=True))
    )
    frame = compare(rows, ["rmse_appearance", "corr"])
    write_text(tmp_path / "comparisons.tsv", all_forms(frame, [TABLE], "x")[0])
    given = {"comparisons": [str(tmp_path / "comparisons.tsv")], "comparison": {"level": 0.05}}
    (table,) = gathering.comparisons(given, ROWS, str(tmp_path / "report.html"))
    assert table.html.count("<table>") == 1 and table.html.count('<th scope="row">') == 3
    assert "▲ 2" in table.html and "▲ 1 ▼ 1" in table.html and "▼ 2" in table.html
    assert table.files == (FileLink("TSV", "comparisons.tsv"),)


def test_the_overview_of_two_systems_is_of_the_utterances_that_both_have(tmp_path):
    ids, given = [f"u{i}" for i in range(8)], []
    for name, missing in (("one", ()), ("two", ("u0",))):
        folder = tmp_path / name
        own = [Utterance(one, "s", f"{one}.mp4", one, "test") for one in ids if one not in missing]
        write_accepted(folder / "utterances.tsv", own, {one.id: one.split for one in own})
        errors = {"FBB-64": 0.3, "FFF-64": 0.5, "training_mean": 1.0}
        tables = {row: lips(error) for row, error in errors.items()}
        lines = [{"row": row, **line} for row, table in tables.items() for line in table.to_dict("records")]
        whole = lip_table(lines)
        kept = whole[~whole["id"].isin(missing)]
        write_table(folder / "lips.tsv", kept.drop(columns=["seconds", "parameters"]))
        write_table(folder / "costs.tsv", kept[["row", "id", "seconds", "parameters"]])
        for row, error in errors.items():
            write_table(folder / f"{row}.tsv", statistics(np.full(3, error)))
        given.append({
            "name": name, "title": f"System {name}", "rows": [row.plain() for row in ROWS], "model": "FFF-64",
            "utterances": str(folder / "utterances.tsv"), "lips": str(folder / "lips.tsv"),
            "costs": str(folder / "costs.tsv"), "comparison": {}, "bootstrap": {"samples": 50},
            "validation": {row: str(folder / f"{row}.tsv") for row in ("FBB-64", "FFF-64")},
        })  # fmt: skip
    found = gathering.overviews(given)
    assert [one.conclusion.choice.best for one in found] == ["FBB-64", "FBB-64"]
    assert all("On the 7 test utterances" in one.conclusion.text for one in found)
    assert [one.spoken for one in found] == ["FFF-64", "FFF-64"]
    figures = [(one.name, row, "lip_distance", "lips", 0.5, 0.4, 0.6) for one in found for row in one.rows]
    frame = pandas.DataFrame(figures, columns=["system", "row", "metric", "part", "value", "low", "high"])
    write_text(tmp_path / "systems.tsv", "# corpus: demo\n# x: y\n" + frame.to_csv(sep="\t", index=False))
    shown = gathering.overview(found, str(tmp_path / "systems.tsv"))
    assert [band.title for band in shown["bands"]] == ["System one", "System two"]
    assert shown["short"].count('<th scope="row">') == 6


def test_a_table_with_facts_is_read_as_written(tmp_path):
    frame = pandas.DataFrame({"row": ["# 1", "NA"], "value": [0.5, np.nan]})
    table = Table("t", ("x",), (), facts=(("corpus", "a\tb"),))
    write_text(tmp_path / "t.tsv", all_forms(frame, [table], "t")[0])
    found = gathering.read_made_table(str(tmp_path / "t.tsv"), ("row",))
    assert list(found["row"]) == ["# 1", "NA"] and found["value"][0] == 0.5 and np.isnan(found["value"][1])
    write_text(tmp_path / "empty.tsv", "# only: facts\n")
    with pytest.raises(StorageError, match="it is no table of a run"):
        gathering.read_made_table(str(tmp_path / "empty.tsv"), ("row",))


def test_files_of_test_utterances_that_exist_are_linked(tmp_path):
    grids = tmp_path / "alignment" / "textgrid"
    grids.mkdir(parents=True)
    (grids / "c.TextGrid").touch()
    inside = tmp_path / "recordings" / "d.mp4"
    inside.parent.mkdir()
    inside.touch()
    utterances = [*UTTERANCES[:3], Utterance("d", "one", str(inside), "words", "test")]
    system = section(tmp_path)
    found = gathering.test_utterances(utterances, str(grids), (system,), str(tmp_path / "report.html"))
    assert [one.id for one in found] == ["c", "d"]
    assert found[0].files == (FileLink("TextGrid", "alignment/textgrid/c.TextGrid"),
                              FileLink("Fan 2015", "fan2015/videos/c.mp4"))  # fmt: skip
    assert found[1].files == (FileLink("recording", "recordings/d.mp4"),)
    folders = gathering.folder_links([str(grids)], str(tmp_path / "report.html"))
    assert folders == (FileLink("textgrid", "alignment/textgrid/"),)
