"""Every benchmark can be imported and is documented; expected figures are compared within their tolerances."""

import ast
import os
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from tests.paths import REPOSITORY
from visualspeech.evaluation.articulation import Target

FOLDER = REPOSITORY / "benchmarks"
#: Runs in an environment of its own, without this project.
FOREIGN = {"menpofit_worker"}
#: What benchmarks share.
SHARED = {"command", "contextual", "memory", "runs", "synthetic"}
BENCHMARKS = sorted({path.stem for path in FOLDER.glob("*.py")} - {"__init__"} - FOREIGN - SHARED)


@pytest.fixture(autouse=True)
def same_environment():
    """Importing the benchmarks sets the environment of jobs; it is given back afterwards."""
    before = dict(os.environ)
    yield
    os.environ.clear()
    os.environ.update(before)


@pytest.mark.parametrize("name", BENCHMARKS)
def test_every_benchmark_can_be_imported_and_says_how_to_run_it(name):
    module = import_module(f"benchmarks.{name}")
    assert f"Run: python -m benchmarks.{name}" in module.__doc__
    assert callable(module.main)
    assert f"| `{name}` |" in (FOLDER / "README.md").read_text()


@pytest.mark.parametrize("name", sorted(FOREIGN))
def test_what_runs_in_another_environment_imports_nothing_of_this_project(name):
    tree = ast.parse((FOLDER / f"{name}.py").read_text())
    modules = [node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    modules += [alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names]
    assert not {module.partition(".")[0] for module in modules} & {"visualspeech", "benchmarks", "tests"}


def test_the_table_of_the_readme_names_existing_benchmarks():
    rows = [line for line in (FOLDER / "README.md").read_text().splitlines() if line.startswith("| `")]
    assert {row.split("`")[1] for row in rows} == set(BENCHMARKS)


def test_peak_memory_is_that_of_the_program_alone():
    """A small program that a large one starts is small."""
    memory = import_module("benchmarks.memory")
    ballast = np.ones(40_000_000)
    code = "from benchmarks.memory import peak_megabytes; print(peak_megabytes())"
    done = subprocess.run([sys.executable, "-c", code], cwd=REPOSITORY, capture_output=True, text=True, check=True)
    assert 1 < float(done.stdout) < 100 < ballast.nbytes / 2**20 < memory.peak_megabytes()


def test_arguments_are_converted_to_the_types_of_the_parameters(monkeypatch, capsys):
    command = import_module("benchmarks.command")

    def main(folder: Path, count: int = 2, *names: str) -> None:
        """For this test."""

    assert command.converted(main, ["a", "3", "b", "c"]) == [Path("a"), 3, "b", "c"]
    for arguments in ([], ["a", "three"]):
        monkeypatch.setattr(sys, "argv", ["benchmark", *arguments])
        with pytest.raises(SystemExit) as ended:
            command.run_main(main, "What it measures.")
        assert ended.value.code == 2
        assert "What it measures." in capsys.readouterr().err
    monkeypatch.setattr(sys, "argv", ["benchmark", "--help"])
    command.run_main(main, "What it measures.")
    assert capsys.readouterr().out == "What it measures.\n"


def test_the_sentences_of_free_text_are_many_and_ask_for_closures():
    lines = (FOLDER / "free_text.txt").read_text().splitlines()
    assert len(lines) == len(set(lines)) == 200
    assert all(set("pbmfv") & set(line.lower()) for line in lines)


def test_occurrences_of_free_text_are_told_apart_by_context():
    articulation = import_module("benchmarks.articulation")
    from visualspeech.speech.alignment import Alignment, Segment

    labels = ("ah", "b", "ah", "f", "sil")
    phones = tuple(Segment(label, 0.2 * k, 0.2 * (k + 1), 0) for k, label in enumerate(labels))
    alignment = Alignment((Segment("word", 0.0, 1.0),), phones, ())
    opening = np.full(25, 9.0)
    opening[7] = 1.0  # 0.3 s, in the "b"
    closures = (Target("bilabial", 2.0, 9), Target("labiodental", 3.0, 9))
    assert articulation.closed([(opening, alignment, 25.0)], closures) == [
        ("bilabial", "b", ("ah", "b", "ah"), True),
        ("labiodental", "f", ("ah", "f", "sil"), False),
    ]
    assert articulation.triphones_of(alignment)[0] == ("sil", "ah", "b")
    assert articulation.in_speech([(np.arange(25.0), alignment, 25.0)]).tolist() == list(range(20))
    assert articulation.rates([("b", True), ("a", False), ("b", False)]) == "a 0.000 (1), b 0.500 (2)"


FACTS = {"split": "abc", "rate": "25 Hz", "visual coding": "aam51 (2 shape, 3 texture, 4 appearance)", "seeds": "1"}
FIGURES = {"FBB-8": ("1.000", "100.000", "0.700"), "training_mean": ("2.000", "0.000", "-0.004")}


def run_of(folder: Path, figures=FIGURES, facts=FACTS) -> Path:
    """Folder of a corpus with the result table of one system; ``FBB-8`` is a network."""
    from visualspeech.storage.files import write_text
    from visualspeech.storage.models import write_model

    system = folder / "results" / "demo" / "fan2015"
    lines = [f"# {name}: {text}" for name, text in facts.items()]
    lines.append("\t".join(("row", "rmse_shape", "rmse_shape_low", "rmse_appearance", "corr")))
    lines += ["\t".join((row, shape, "0.1", rest, corr)) for row, (shape, rest, corr) in figures.items()]
    write_text(system / "tables" / "objective.tsv", "\n".join(lines) + "\n")
    for row in figures:
        family = "stack" if row.startswith("F") else "mean"
        write_model(system / "models" / row / "model.safetensors", {}, {"kind": "model", "family": family})
    return folder / "results" / "demo"


def compared(tmp_path, capsys, figures=FIGURES, facts=FACTS) -> tuple[int, str]:
    """Exit status and output of comparing a run with what was expected of :data:`FIGURES`."""
    main = import_module("benchmarks.expected").main
    main(run_of(tmp_path / "before"), write=True, folder=tmp_path)
    capsys.readouterr()
    status = main(run_of(tmp_path / "now", figures, facts), folder=tmp_path)
    return status, capsys.readouterr().out


def test_the_file_of_expected_figures_says_what_they_were_computed_on(tmp_path):
    import numpy
    import torch

    import_module("benchmarks.expected").main(run_of(tmp_path), write=True, folder=tmp_path)
    written = (tmp_path / "demo.tsv").read_text()
    assert "# split: abc\n" in written and "# fan2015 rate: 25 Hz\n" in written and "# fan2015 seeds: 1\n" in written
    assert f"torch {torch.__version__.partition('+')[0]}" in written and f"numpy {numpy.__version__}" in written
    assert "\ncorpus\tsystem\trow\tmetric\tvalue\ttolerance\n" in written
    assert "\ndemo\tfan2015\tFBB-8\trmse_appearance\t100.000\t2\n" in written
    assert "\ndemo\tfan2015\tFBB-8\tcorr\t0.700\t0.02\n" in written
    assert "\ndemo\tfan2015\ttraining_mean\trmse_shape\t2.000\t0.01\n" in written
    assert "\ndemo\tfan2015\ttraining_mean\trmse_appearance\t0.000\t0.001\n" in written


def test_the_same_figures_and_figures_within_their_tolerance_pass(tmp_path, capsys):
    status, output = compared(tmp_path, capsys)
    assert status == 0
    assert output == "6 expected figures: 6 within their tolerance (6 of them equal), 0 outside or missing\n"
    near = {"FBB-8": ("1.020", "98.000", "0.720"), "training_mean": ("1.990", "0.001", "-0.004")}
    status, output = compared(tmp_path, capsys, near)
    assert status == 0 and "(1 of them equal), 0 outside" in output


def test_figures_outside_their_tolerance_and_missing_ones_are_named(tmp_path, capsys):
    status, output = compared(tmp_path, capsys, {**FIGURES, "training_mean": ("2.011", "0.000", "")})
    assert status == 1
    assert "fan2015 training_mean rmse_shape: 2.011; expected 2.000 ± 0.01\n" in output
    assert "fan2015 training_mean corr: missing; expected -0.004\n" in output
    assert "6 expected figures: 4 within their tolerance (4 of them equal), 2 outside or missing\n" in output
    assert compared(tmp_path, capsys, {**FIGURES, "FBB-8": ("nan", "100.000", "0.700")})[0] == 1


def test_other_rows_are_reported(tmp_path, capsys):
    status, output = compared(tmp_path, capsys, {**FIGURES, "FB-8": ("1.000", "1.000", "0.700")})
    assert status == 0 and "fan2015: no figures are expected of the rows FB-8." in output
    status, output = compared(tmp_path / "less", capsys, {"FBB-8": FIGURES["FBB-8"]})
    assert status == 1 and "fan2015: the run lacks the rows training_mean." in output


def test_a_run_on_other_data_is_not_compared(tmp_path, capsys):
    status, output = compared(tmp_path, capsys, facts={**FACTS, "split": "other"})
    assert status == 1
    assert "was made from other data: its split is other, that of the expected figures abc." in output


def test_other_facts_are_reported(tmp_path, capsys):
    status, output = compared(tmp_path, capsys, facts={**FACTS, "seeds": "2"})
    assert status == 0 and "fan2015: seeds is 2; expected 1." in output


def test_folders_without_tables_and_corpora_without_expected_figures_are_named(tmp_path):
    from visualspeech.errors import StorageError

    main = import_module("benchmarks.expected").main
    with pytest.raises(StorageError, match="holds no <system>/tables/objective.tsv"):
        main(tmp_path, folder=tmp_path)
    with pytest.raises(StorageError, match="no expected figures of demo"):
        main(run_of(tmp_path), folder=tmp_path / "none")


@pytest.mark.parametrize("corpus", ["demo", "grid"])
def test_the_expected_figures_of_the_repository_can_be_read(corpus):
    expected = import_module("benchmarks.expected").read_expected(FOLDER / "expected" / f"{corpus}.tsv")
    assert expected.split and expected.facts["fan2015", "rate"] == "25 Hz"
    systems = [figure.system for figure in expected.figures]
    assert systems.count("fan2015") == 22 * 7 and set(systems) == {"fan2015", "thangthai2016", "sadoughi2017"}
    assert min(expected.tolerances.values()) > 0
