"""The page of the library: its examples run, one after the other, on the finished tiny run."""

import contextlib
import io
import re
import shlex
import shutil

import pytest

from tests.paths import REPOSITORY
from tests.workflow.running import overlay, snakemake
from visualspeech.cli import main

pytestmark = pytest.mark.xdist_group("workflow")

PAGE, FILES = (REPOSITORY / "docs" / name for name in ("library.md", "data.md"))
#: Names of the demo run on the page, and what they are called in the tiny run.
NAMES = {"FBB-128-lips": "FB-16", "FBB-128": "FB-16", "recordings/2/": "recordings/0/"}
MAX_LINES = 5  # of an example, beside its imports


def examples(page=PAGE):
    """Line of a page and text of each example."""
    text = page.read_text(encoding="utf-8")
    for block in re.finditer(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL):
        yield text[: block.start()].count("\n") + 2, block[1]


def renamed(text):
    for name, own in NAMES.items():
        text = text.replace(name, own)
    return text


def run_examples(page, names):
    for line, text in examples(page):
        exec(compile("\n" * (line - 1) + renamed(text), str(page), "exec"), names)  # noqa: S102


@pytest.fixture(scope="module")
def folder(tiny_run, tmp_path_factory):
    """A working folder in which the tiny run is called demo, with a speaker."""
    files = overlay(tmp_path_factory.mktemp("settings"), {"speak": {"background_seconds": 5}})
    done = snakemake(tiny_run, "speaker", configfiles=files)
    assert done.returncode == 0, done.stdout[-4000:]
    made = tmp_path_factory.mktemp("library")
    (made / "results").mkdir()
    (made / "results" / "demo").symlink_to(tiny_run / "results" / "tiny")
    return made


def test_the_examples_of_the_page_run(folder, monkeypatch):
    monkeypatch.chdir(folder)
    names, printed = {}, io.StringIO()
    with contextlib.redirect_stdout(printed):
        run_examples(PAGE, names)
    assert {path.name for path in folder.iterdir()} == {
        "results", "demo003.TextGrid", "mine.safetensors", "said.mp4", "demo_arrays",
    }  # fmt: skip
    assert names["tracked"].points.shape == (81, 68, 2) and names["parameters"].shape[0] == 81
    assert names["image"].ndim == 3 and names["said"].seconds > 1
    assert "'rmse_appearance': " in printed.getvalue() and "(75, 51, 2)" in printed.getvalue()


def test_the_commands_of_the_pages_run(folder, tmp_path, monkeypatch):
    (tmp_path / "results").symlink_to(folder / "results")
    monkeypatch.chdir(tmp_path)
    text = renamed(PAGE.read_text(encoding="utf-8") + FILES.read_text(encoding="utf-8"))
    commands = re.findall(r"^visualspeech (export .*)$|`visualspeech (export [^`]*)`", text, re.MULTILINE)
    assert len(commands) == 3
    for command in map("".join, commands):
        shutil.rmtree(tmp_path / command.split()[-1], ignore_errors=True)
        assert main(shlex.split(command)) == 0, command
    assert {path.name for path in tmp_path.iterdir()} == {"results", "demo_arrays", "demo_tables"}
    names, printed = {}, io.StringIO()
    with contextlib.redirect_stdout(printed):
        run_examples(FILES, names)
    assert "demo003 25.0 (81, 68, 2)" in printed.getvalue() and "rmse_appearance" in names["table"]


def test_examples_are_short():
    for line, text in examples():
        own = [one for one in text.splitlines() if one.strip() and not one.startswith(("import ", "from "))]
        assert len(own) <= MAX_LINES, line


def test_the_scores_of_a_run_are_those_of_its_tables(tiny_run):
    from visualspeech import Run, score

    system = Run(tiny_run / "results" / "tiny").system("fan2015")
    assert system.table("objective").attrs["corpus"] == "tiny"
    table = system.table("objective").set_index("row")
    articulation = system.table("articulation").set_index("row")
    for model in ("FB-16", "hmm_mge", "training_mean"):
        found, own = system.scores(model), score(system.predictions(model), system.truths())
        for name in ("rmse_shape", "rmse_texture", "rmse_appearance", "corr", "lip_distance_px"):
            assert found[name] == pytest.approx(table.loc[model, name], abs=6e-4)
        assert articulation.loc[model, "opening_corr"] == pytest.approx(found["opening_corr"], abs=6e-4, nan_ok=True)
        for name, value in own.items():
            assert found[name] == pytest.approx(value, rel=1e-9, nan_ok=True), name
    assert sorted(table.index) == system.models


def test_a_model_that_is_trained_again_predicts_what_the_run_predicts(tiny_run):
    """The same settings, data and seed: the facade trains as the run does."""
    import numpy as np

    from visualspeech import Run, predict, train
    from visualspeech.storage.models import read_model_settings

    system = Run(tiny_run / "results" / "tiny").system("fan2015")
    trained = read_model_settings(system.folder / "models/FB-16/model.safetensors")
    about = {name: value for name, value in trained["about"]["training"].items() if name != "seed"}
    settings = {**trained["settings"], **about}
    reads = [block["name"] for block in trained["blocks"]]
    fitted = train(
        *(system.examples(split, reads) for split in ("train", "validation")),
        seed=trained["about"]["training"]["seed"],
        **settings,
    )
    test = system.examples("test", reads)
    for number, name in enumerate(test.ids):
        assert np.array_equal(predict(fitted.model, test[number]), system.prediction("FB-16", name))
        assert np.array_equal(
            predict(system.model("FB-16"), system.run.alignment(name)), system.prediction("FB-16", name)
        )
