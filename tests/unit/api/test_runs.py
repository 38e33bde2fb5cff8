"""Reading of a results folder: what it gives, and what is said where something is missing."""

import shutil

import numpy as np
import pytest

from tests.unit.api import results
from visualspeech import DataError, Run, StorageError
from visualspeech.storage.arrays import ArrayReader, ArrayWriter


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return results.make(tmp_path_factory.mktemp("results") / "made")


@pytest.fixture(scope="module")
def run(folder):
    return Run(folder)


def test_a_run_lists_what_it_has(run, folder):
    assert run.corpus == "made" and list(run.systems) == ["fan2015"]
    assert list(run.utterances["id"]) == list(results.SPLIT) and len(run.findings) == 0
    assert list(run.findings.columns) == ["id", "stage", "level", "file", "finding", "remedy"]
    system = run.system("fan2015")
    assert system.models == list(results.MODELS) and system.tables == ["objective"]
    assert system.ids() == ["c1", "c2"] and system.ids("train") == ["a1", "a2"]
    assert system.coding_folder == folder / "codings" / "aam51" and system.coding.size == 4
    assert repr(system) == f"Run('{folder}').system('fan2015')"


def test_trajectories_are_those_of_the_files(run, folder):
    system = run.system("fan2015")
    with ArrayReader(folder / "fan2015/targets/1.h5") as targets:
        assert np.array_equal(system.truth("c2"), targets.array("c2", "appearance"))
    with ArrayReader(folder / "fan2015/models/second/predictions.h5") as predictions:
        assert np.array_equal(system.prediction("second", "b1"), predictions.array("b1", "appearance"))
    assert list(system.predictions("first")) == ["c1", "c2"] == list(system.truths())
    assert system.points(system.truth("c1"), "c1").shape == (results.FRAMES, 51, 2)
    assert system.rate("c1") == 25 and system.times("c1")[:2].tolist() == [0.02, 0.06]


def test_a_run_can_be_closed(folder):
    with Run(folder) as run:
        before = run.system("fan2015").truth("c1")
    assert not run._opened
    assert np.array_equal(run.system("fan2015").truth("c1"), before)
    run.close()


def test_labels_are_those_of_the_frames(run):
    labels = run.system("fan2015").labels("c1")
    assert list(labels.columns) == ["time", "word", "phone", "state"]
    assert labels["phone"].tolist() == ["sil"] * 5 + ["b"] * 5 + ["iy"] * 5 + ["sil"] * 5
    assert labels["word"].tolist()[5:15] == ["bee"] * 10
    assert labels["state"].tolist()[:5] == ["1", "1", "2", "3", "3"]


def test_tables_say_what_they_are_about(run):
    table = run.system("fan2015").table()
    assert table.attrs == {"corpus": "made", "rate": "25 Hz"} and table.loc[0, "corr"] == 0.5
    assert run.system("fan2015").scores("first")["ccc_lower"] == pytest.approx(1)


@pytest.mark.parametrize(
    ("ask", "said"),
    [
        (lambda run: run.system("fan"), "has no system 'fan'; it has fan2015"),
        (lambda run: run.alignment("x"), "has no utterance 'x'; it has a1, a2, b1, c1, c2"),
        (lambda run: run.table(), "has no table 'systems'; it has none"),
        (lambda run: run.system("fan2015").truth("x"), "has no utterance 'x'"),
        (lambda run: run.system("fan2015").speaker("x"), "has no utterance 'x'"),
        (
            lambda run: run.system("fan2015").prediction("third", "c1"),
            "no predictions of the model 'third'; it has fir",
        ),
        (lambda run: run.system("fan2015").prediction("first", "a1"), "a1 is a train utterance"),
        (lambda run: run.system("fan2015").ids("dev"), "no split 'dev'; give one of train, validation, test"),
        (lambda run: run.system("fan2015").examples("train", ["tri"]), "no input block 'tri'; it has none"),
        (lambda run: run.system("fan2015").examples("train", []), "at least one input block"),
        (lambda run: run.system("fan2015").model("third"), "no trained model 'third'; it has first, second"),
        (lambda run: run.system("fan2015").learning_curve("third"), "no trained model 'third'"),
        (lambda run: run.system("fan2015").scores("third"), "no statistics of the model 'third'"),
        (lambda run: run.system("fan2015").table("x"), "has no table 'x'; it has objective"),
    ],
)
def test_what_is_not_there_is_named(run, ask, said):
    with pytest.raises(DataError, match=said):
        ask(run)


def test_other_folders_are_refused(folder, tmp_path):
    with pytest.raises(StorageError, match="does not exist. Give the results folder of a corpus"):
        Run(tmp_path / "nowhere")
    (tmp_path / "file").write_text("")
    with pytest.raises(StorageError, match="file is a file"):
        Run(tmp_path / "file")
    with pytest.raises(StorageError, match="no results folder of a corpus. Give one, for example results/demo"):
        Run(tmp_path)
    with pytest.raises(StorageError, match=f"it holds those of made. Give one, for example {folder}"):
        Run(folder.parent)


def test_an_unfinished_run_is_reported(folder, tmp_path):
    made = shutil.copytree(folder, tmp_path / "made")
    with pytest.raises(StorageError, match="no landmarks/\\*.h5. Run the workflow's target `all` to its end"):
        Run(made).landmarks("c1")
    shutil.rmtree(made / "fan2015" / "models")
    with pytest.raises(StorageError, match="has no trained model"):
        _ = Run(made).system("fan2015").coding
    (made / "utterances.tsv").unlink()
    with pytest.raises(StorageError, match="is not finished: it has no utterances.tsv"):
        Run(made)


def test_recorded_faces_are_landmarks_or_motion_capture(folder, tmp_path):
    made = shutil.copytree(folder, tmp_path / "made")
    markers = np.arange(24.0).reshape(4, 2, 3)
    with ArrayWriter(made / "motion" / "0.h5") as out:
        out.add("c1", {"points": markers}, 120.0)
    with Run(made) as run:
        assert np.array_equal(run.motion("c1"), markers) and run.rate("c1") == 120
    points = np.zeros((3, 68, 2))
    for name in ("landmarks", "pose"):
        with ArrayWriter(made / name / "0.h5") as out:
            out.add("c1", {"points": points + len(name)}, 25.0)
    with ArrayWriter(made / "audio" / "0.h5") as out:
        out.add("c1", {"samples": np.arange(9, dtype=np.int16)}, 16_000)
    with Run(made) as run:
        assert run.rate("c1") == 25 and run.landmarks("c1")[0, 0, 0] == 9 and run.frontal("c1")[0, 0, 0] == 4
        assert run.sound("c1")[0].tolist() == list(range(9)) and run.sound("c1")[1] == 16_000
        with pytest.raises(DataError, match="has no utterance 'c2'; it has c1"):
            run.landmarks("c2")


def test_models_of_another_coding_are_reported(folder, tmp_path):
    made = shutil.copytree(folder, tmp_path / "made")
    path = made / "codings" / "aam51" / "model.safetensors"
    path.write_bytes(path.read_bytes() + b" ")
    with pytest.raises(StorageError, match="was trained for a visual coding that .* lacks"):
        _ = Run(made).system("fan2015").coding
