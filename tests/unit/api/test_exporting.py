"""Export of a run: content of the files, choice, mistakes, and that it is whole or absent."""

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import h5py
import numpy as np
import pandas
import pytest

from tests.unit.api import results
from visualspeech import Run, export_run
from visualspeech.api import exporting
from visualspeech.cli import main
from visualspeech.storage.arrays import ArrayWriter


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return results.make(tmp_path_factory.mktemp("results") / "made")


def told(capsys, *arguments):
    """Exit status and what is said on standard error."""
    try:
        status = main(["export", *map(str, arguments)])
    except SystemExit as left:
        status = left.code
    return status, capsys.readouterr().err


def names(folder):
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


def test_numpy_files_hold_everything_and_need_no_pickle(folder, tmp_path):
    out = export_run(folder, tmp_path / "out", "npz", points=True)
    assert names(out) == {"README.txt", "fan2015/utterances.csv", *(f"fan2015/{name}.npz" for name in results.SPLIT)}
    system = Run(folder).system("fan2015")
    with np.load(out / "fan2015" / "c1.npz", allow_pickle=False) as arrays:
        found = {name: arrays[name] for name in arrays}
    assert set(found) == {
        "rate", "times", "word", "phone", "state", "segment_tier", "segment_label", "segment_start", "segment_end",
        *(f"{what}.{key}" for what in ("parameters", "points") for key in ("truth", "first", "second")),
    }  # fmt: skip
    assert np.array_equal(found["parameters.truth"], system.truth("c1")) and found["rate"] == 25
    assert np.array_equal(found["parameters.second"], system.prediction("second", "c1"))
    assert np.array_equal(found["points.first"], system.points(system.prediction("first", "c1")))
    assert np.array_equal(found["times"], system.times("c1"))
    assert found["phone"].tolist() == system.labels("c1")["phone"].tolist()
    words = found["segment_tier"] == "word"
    assert found["segment_label"][words].tolist() == ["sil", "bee", "sil"]
    assert found["segment_end"][words].tolist() == pytest.approx([0.2, 0.6, 0.8])
    with np.load(out / "fan2015" / "a1.npz", allow_pickle=False) as arrays:
        assert "parameters.truth" in arrays and "parameters.first" not in arrays


def test_tables_hold_the_same(folder, tmp_path):
    out = export_run(folder, tmp_path / "out", "csv", splits=["test"], models=["first"], points=True)
    own = out / "fan2015"
    assert names(own) == {"utterances.csv"} | {
        f"{place}/{name}.csv"
        for name in ("c1", "c2")
        for place in (
            "labels", "segments", "truth/parameters", "truth/points", "predictions/first/parameters",
            "predictions/first/points",
        )
    }  # fmt: skip
    system = Run(folder).system("fan2015")
    truth = pandas.read_csv(own / "truth/parameters/c1.csv")
    assert list(truth.columns) == ["time_s", "p1", "p2", "p3", "p4"]
    assert np.array_equal(truth.to_numpy()[:, 1:].astype(np.float32), system.truth("c1"))
    assert truth["time_s"].tolist() == pytest.approx(system.times("c1"))
    points = pandas.read_csv(own / "predictions/first/points/c2.csv")
    assert list(points.columns[:4]) == ["time_s", "x0", "y0", "x1"] and points.shape == (results.FRAMES, 103)
    assert points["y1"].to_numpy() == pytest.approx(system.points(system.prediction("first", "c2"))[:, 1, 1])
    labels = pandas.read_csv(own / "labels/c1.csv", dtype=str)
    assert labels["state"].tolist() == system.labels("c1")["state"].tolist()
    listed = pandas.read_csv(own / "utterances.csv")
    assert listed.loc[0].to_dict() == {
        "id": "c1", "speaker": "ann", "split": "test", "emotion": pytest.approx(np.nan, nan_ok=True),
        "transcript": 'Hello, "all"!', "rate_hz": 25.0, "frames": results.FRAMES,
    }  # fmt: skip
    said = (out / "README.txt").read_text()
    assert "fan2015: 4 parameters of the visual coding aam51" in said and "51 points of lower_face_51" in said


def test_the_command_chooses(folder, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    chosen = ["--npz", "--system", "fan2015", "--model", "first", "--model", "second"]
    assert told(capsys, folder, *chosen, "--utterance", "c2", "--utterance", "b1", "--quiet") == (0, "")
    assert names(tmp_path / "made_npz") == {
        "README.txt", "fan2015/utterances.csv", "fan2015/b1.npz", "fan2015/c2.npz",
    }  # fmt: skip
    (tmp_path / "empty").mkdir()
    status, said = told(capsys, folder, "--csv", "-o", "empty")
    assert status == 0 and "empty: 5 utterances of fan2015" in said and (tmp_path / "empty/README.txt").is_file()


def test_a_model_chooses_its_systems(folder, tmp_path):
    made = shutil.copytree(folder, tmp_path / "made")
    shutil.copytree(made / "fan2015", made / "other")
    shutil.rmtree(made / "other/models/second")
    assert {path.parts[0] for path in map(Path, names(export_run(made, tmp_path / "all")))} >= {"fan2015", "other"}
    chosen = names(export_run(made, tmp_path / "second", models=["second"]))
    assert {path.parts[0] for path in map(Path, chosen)} == {"README.txt", "fan2015"}
    both = names(export_run(made, tmp_path / "both", models=["second"], systems=["other", "fan2015"]))
    assert "other/truth/parameters/c1.csv" in both and "other/predictions" not in str(both)


@pytest.mark.parametrize(
    ("arguments", "status", "said"),
    [
        ([], 2, "one of the arguments --csv --npz is required"),
        (["--csv", "--npz"], 2, "not allowed with"),
        (["--csv", "--system", "fan"], 2, "the run has no system 'fan'; it has fan2015."),
        (["--csv", "--model", "third"], 2, "the run has no model 'third'; it has first, second."),
        (["--csv", "--split", "dev"], 2, "the run has no split 'dev'; it has train, validation, test."),
        (["--csv", "--utterance", "x"], 2, "the run has no utterance 'x'; it has a1, a2, b1, c1, c2."),
        (["--csv", "--utterance", "a1", "--split", "test"], 2, "no utterance is of this choice"),
        (["--csv", "-o", "full"], 2, "full holds files; give the name of a new folder."),
        (["--csv", "-o", "full/file"], 2, "exists and is no folder"),
        (["--csv", "-o", "link"], 2, "exists and is no folder"),
        (["--csv", "-o", "RUN/export"], 2, "lies in the results of the run; give a folder outside."),
        (["--csv", "-o", "full/file/out"], 1, "cannot write full/file/out"),
        (["--csv", "-o", "/proc/nowhere/out"], 1, "cannot write /proc/nowhere/out"),
    ],
)
def test_mistakes_are_told_in_a_sentence(folder, tmp_path, capsys, monkeypatch, arguments, status, said):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "file").write_text("")
    (tmp_path / "link").symlink_to("nowhere")
    before = names(tmp_path)
    found, error = told(capsys, folder, *(one.replace("RUN", str(folder)) for one in arguments))
    assert found == status and said in error and "Traceback" not in error, error
    assert names(tmp_path) == before and not (folder / "export").exists()


def test_what_is_no_finished_run_is_told(folder, tmp_path, capsys):
    out = tmp_path / "out"
    status, said = told(capsys, tmp_path, "--csv", "-o", out)
    assert status == 1 and "is no results folder of a corpus" in said
    made = shutil.copytree(folder, tmp_path / "made")
    (made / "fan2015/targets/1.h5").unlink()
    status, said = told(capsys, made, "--csv", "-o", out)
    assert status == 1 and "is not finished: fan2015 has no targets of c1" in said
    (made / "fan2015/targets/0.h5").write_bytes(b"nothing")
    status, said = told(capsys, made, "--csv", "-o", out)
    assert status == 1 and "cannot read" in said and "0.h5" in said
    shutil.rmtree(made / "fan2015")
    status, said = told(capsys, made, "--csv", "-o", out)
    assert status == 1 and "has no system yet" in said
    assert not out.exists()


def test_ids_that_are_paths_are_refused(folder, tmp_path, capsys):
    made = shutil.copytree(folder, tmp_path / "made")
    path = made / "codings/aam51/utterances.tsv"
    path.write_text(path.read_text().replace("c1\t", "../../c1\t", 1))
    (made / "fan2015/targets/0.h5").unlink()
    with ArrayWriter(made / "fan2015/targets/0.h5") as out:
        for name in ("a1", "a2", "b1"):
            out.add(name, {"appearance": np.zeros((20, 4), np.float32)}, 25.0)
    with h5py.File(made / "fan2015/targets/0.h5", "a") as file:
        file.copy("a1", "../../c1")
    status, said = told(capsys, made, "--csv", "-o", tmp_path / "out")
    assert status == 1 and "Traceback" not in said and "c1" in said
    assert {one.name for one in tmp_path.iterdir()} == {"made"}


def test_an_export_that_fails_leaves_nothing(folder, tmp_path, monkeypatch, capsys):
    write, done = exporting._write_npz, []

    def full(own, name, exported):
        if done:
            raise OSError(28, "No space left on device")
        done.append(name)
        write(own, name, exported)

    monkeypatch.setattr(exporting, "_write_npz", full)
    status, said = told(capsys, folder, "--npz", "-o", tmp_path / "out")
    assert status == 1 and "No space left on device" in said and f"cannot write {tmp_path / 'out'}" in said
    assert list(tmp_path.iterdir()) == []


SLOW = """
import sys, time
from visualspeech.api import exporting
write = exporting._write_npz
def slow(*given):
    write(*given)
    print("written", flush=True)
    time.sleep(60)
exporting._write_npz = slow
from visualspeech.cli import main
from visualspeech.storage.arrays import ArrayWriter
sys.exit(main(sys.argv[1:]))
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_a_killed_export_leaves_nothing_under_its_name(folder, tmp_path, number):
    if number != signal.SIGKILL and signal.getsignal(number) == signal.SIG_IGN:
        pytest.skip("this signal is ignored here, as under nohup")
    command = [sys.executable, "-c", SLOW, "export", str(folder), "--npz", "-o", str(tmp_path / "out")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == "written\n"
        os.kill(process.pid, number)
        _, said = process.communicate(timeout=20)
    assert not (tmp_path / "out").exists()
    if number == signal.SIGKILL:
        assert len(list(tmp_path.iterdir())) == 1
        time.sleep(0.1)
    else:
        assert list(tmp_path.iterdir()) == [] and "nothing was written" in said and process.returncode == 128 + number
    export_run(folder, tmp_path / "out", "npz")
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
