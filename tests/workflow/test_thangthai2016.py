"""The system thangthai2016 on the recordings of the tiny run: its rows, tables, figure, videos and talking head."""

import shutil

import pandas
import pytest

from tests.described_files import undescribed
from tests.workflow.running import of_system, overlay, snakemake

pytestmark = pytest.mark.xdist_group("workflow")


@pytest.fixture(scope="module")
def run(tiny_run, tmp_path_factory):
    """The finished tiny run with this system, and the files of its settings."""
    sentences = {"sentences": ["Nine blue boats."]}
    files = overlay(tmp_path_factory.mktemp("thangthai"), {"systems": ["fan2015", "thangthai2016"], "speak": sentences})
    done = snakemake(tiny_run, "all", configfiles=files)
    assert done.returncode == 0, done.stdout[-6000:]
    yield tiny_run, files, done.stdout
    for name in ("thangthai2016", "codings/aam34"):
        shutil.rmtree(tiny_run / "results" / "tiny" / name)
    restored = snakemake(tiny_run, "all")
    assert restored.returncode == 0, restored.stdout[-4000:]


def test_the_system_runs_beside_the_first_on_a_coding_of_its_own(run):
    folder, _, said = run
    again = {line.split()[1].rstrip(":") for line in said.splitlines() if line.startswith("rule ")}
    assert not again & {"track_landmarks", "align_speech", "normalise_pose", "accept_utterances"}
    assert "fan2015/models" not in "".join(line for line in said.splitlines() if "output:" in line)
    assert (folder / "results/tiny/codings/aam34/model.safetensors").is_file()


def test_its_tables_say_what_rows_know_and_what_the_paper_prints(run):
    folder = run[0] / "results/tiny/thangthai2016/tables"
    units = (folder / "units.md").read_text()
    assert "Oracle rows: oracle DV DNN, phone + oracle DV DNN." in units
    assert "Predicted visemes are a function of the phones" in units and "10.82 ± 2.13" in units
    frame = pandas.read_csv(folder / "units.tsv", sep="\t", comment="#")
    ours = frame[(frame["source"] == "run") & (frame["metric"] == "corr_first5")]
    assert list(ours["row"])[:3] == ["hsmm", "hsmm_mge", "phone"] and set(frame["source"]) == {"run", "published"}
    assert "9.39 ± 2.23" in (folder / "frame_features.md").read_text()
    assert "7.18 ± 1.26" in (folder / "layers.md").read_text()
    objective = (folder / "objective.md").read_text()
    oracle = [line for line in objective.splitlines() if line.startswith("| phone + oracle DV DNN")]
    assert oracle and not any("**" in line for line in oracle)


def test_its_figure_and_video_stand_in_the_report(run):
    folder = run[0] / "results/tiny"
    assert (folder / "thangthai2016/figures/trajectories.png").read_bytes().startswith(b"\x89PNG")
    assert len(list((folder / "thangthai2016/videos").glob("*.mp4"))) == 1
    report = (folder / "report.html").read_text()
    assert "Parameter 5 of a test utterance" in report and "Thangthai et al. 2016" in report
    assert report.count("The most frequent classes of dynamic visemes") >= 1
    assert (folder / "thangthai2016/features/dv/visemes.png").is_file()


def test_the_number_of_visemes_is_a_target_of_its_own(run):
    folder, files, said = run
    assert "rule try_viseme_number" not in said
    few = overlay(files[1].parent, {"systems": ["thangthai2016"]}, of_system("thangthai2016", viseme_numbers={
        "classes": [4, 9]}), name="numbers.yaml")  # fmt: skip
    done = snakemake(folder, "viseme_numbers", configfiles=few)
    assert done.returncode == 0, done.stdout[-4000:]
    assert undescribed(folder / "results/tiny") == []
    table = pandas.read_csv(folder / "results/tiny/thangthai2016/tables/viseme_numbers.tsv", sep="\t", comment="#")
    assert sorted(set(table["classes"])) == [4, 9]
    many = overlay(files[1].parent, {"systems": ["thangthai2016"]}, of_system("thangthai2016", viseme_numbers={
        "classes": [9999]}), name="many.yaml")  # fmt: skip
    refused = snakemake(folder, "viseme_numbers", configfiles=many)
    assert refused.returncode != 0 and "`classes: 9999` asks for more classes of dynamic visemes" in refused.stdout
    assert "Traceback" not in refused.stdout
    without = snakemake(folder, "--dry-run", "viseme_numbers")
    assert without.returncode != 0 and "Traceback" not in without.stdout
    assert "no selected system has an input block of kind dynamic_visemes" in without.stdout


def test_it_speaks_with_predicted_visemes(run):
    folder, files, _ = run
    changed = overlay(files[1].parent, {"systems": ["fan2015", "thangthai2016"]}, {
        "speak": {"system": "thangthai2016", "sentences": ["Nine blue boats."]}}, name="speak.yaml")  # fmt: skip
    done = snakemake(folder, "speak", configfiles=changed)
    assert done.returncode == 0, done.stdout[-4000:]
    assert [path.name for path in (folder / "results/tiny/thangthai2016/spoken").glob("*.mp4")] == ["001.mp4"]
    told = overlay(files[1].parent, {"systems": ["fan2015", "thangthai2016"]}, {
        "speak": {"system": "thangthai2016", "model": "phone_dv_oracle"}}, name="oracle.yaml")  # fmt: skip
    refused = snakemake(folder, "--dry-run", "speak", configfiles=told)
    assert refused.returncode != 0 and "reads dynamic visemes of the recording" in refused.stdout
    assert "Traceback" not in refused.stdout
