"""The system sadoughi2017 on the tiny run, and on two speakers with emotions: rows, tables, controls, report."""

import shutil

import pandas
import pytest

from tests.described_files import undescribed
from tests.workflow.running import overlay, snakemake
from visualspeech.face.marker_coding import MarkerCoding
from visualspeech.storage.arrays import ArrayReader

pytestmark = pytest.mark.xdist_group("workflow")

PAIR = {
    "name": "pair",
    "adapter": "demo",
    "speakers": ["alex", "robin"],
    "emotions": ["neutral", "happiness"],
    "utterances": 12,
    "consent": "Nobody's faces; made by this project.",
}
ROWS = ["Separate-1-8", "Joint-1-8", "Separate-2-8", "Joint-2-8"]


@pytest.fixture(scope="module")
def run(tiny_run, tmp_path_factory):
    """The finished tiny run with this system, and the files of its settings."""
    files = overlay(tmp_path_factory.mktemp("sadoughi"), {"systems": ["fan2015", "sadoughi2017"]})
    done = snakemake(tiny_run, "all", configfiles=files)
    assert done.returncode == 0, done.stdout[-6000:]
    yield tiny_run, files, done.stdout
    for name in ("sadoughi2017", "codings/markers"):
        shutil.rmtree(tiny_run / "results" / "tiny" / name)
    restored = snakemake(tiny_run, "all")
    assert restored.returncode == 0, restored.stdout[-4000:]


@pytest.fixture(scope="module")
def pair(tmp_path_factory):
    """Results of a run of two speakers with emotions."""
    folder = tmp_path_factory.mktemp("pair")
    files = overlay(folder, {"systems": ["sadoughi2017"], "corpora": [PAIR]})
    done = snakemake(folder, "all", configfiles=files)
    assert done.returncode == 0, done.stdout[-6000:]
    return folder / "results/pair"


def test_the_system_uses_the_recordings_of_the_first(run):
    folder, _, said = run
    again = {line.split()[1].rstrip(":") for line in said.splitlines() if line.startswith("rule ")}
    assert not again & {"track_landmarks", "align_speech", "normalise_pose", "accept_utterances", "fit_aam"}
    assert "fan2015/models" not in "".join(line for line in said.splitlines() if "output:" in line)
    with ArrayReader(folder / "results/tiny/sadoughi2017/targets/0.h5") as targets:
        one = targets.ids[0]
        assert targets.rate(one) == 25 and targets.array(one, "appearance").shape[1] == 136


def test_it_stands_in_the_tables_of_the_corpus(run):
    folder = run[0] / "results/tiny"
    regions = pandas.read_csv(folder / "sadoughi2017/tables/regions.tsv", sep="\t", comment="#")
    ours = regions[regions["source"] == "run"] if "source" in regions else regions
    assert list(dict.fromkeys(ours["row"]))[:4] == ROWS
    text = (folder / "sadoughi2017/tables/regions.md").read_text()
    assert "0.413" in text and "50.8M" in text  # figures of the paper
    systems = pandas.read_csv(folder / "tables/systems.tsv", sep="\t", comment="#")
    lips = systems[(systems["part"] == "lips") & (systems["metric"] == "lip_distance")].set_index("row")["value"]
    assert lips[ROWS].notna().all() and "FB-16" in lips
    assert not (folder / "sadoughi2017/tables/articulation.tsv").exists()
    assert not (folder / "sadoughi2017/tables/emotions.tsv").exists()  # the corpus has none


def test_its_videos_and_controls_stand_in_the_report(run):
    folder = run[0] / "results/tiny"
    videos = folder / "sadoughi2017/videos"
    assert sorted({path.suffix for path in videos.glob("[!.]*")}) == [".csv", ".fap", ".mp4"]
    assert next(videos.glob("*.fap")).read_text().startswith("2.1 ")
    report = (folder / "report.html").read_text()
    assert f"sadoughi2017/videos/{next(videos.glob('*.mp4')).name}" in report and "Sadoughi &amp; Busso 2017" in report


def test_it_does_not_speak(run):
    folder, files, _ = run
    alone = overlay(files[1].parent, {"systems": ["sadoughi2017"]}, name="alone.yaml")
    for target in ("speak", "speaker"):
        refused = snakemake(folder, "--dry-run", target, configfiles=alone)
        assert refused.returncode != 0 and "Traceback" not in refused.stdout
        assert "markers" in refused.stdout.splitlines()[-1]
    named = overlay(files[1].parent, {"speak": {"system": "sadoughi2017"}, "systems": ["fan2015", "sadoughi2017"]},
                    name="named.yaml")  # fmt: skip
    refused = snakemake(folder, "--dry-run", "speak", configfiles=named)
    assert refused.returncode != 0 and "`speak.system: sadoughi2017` cannot speak" in refused.stdout
    both = snakemake(folder, "--dry-run", "speak", configfiles=files)
    assert both.returncode == 0 and "fan2015/speakers" in both.stdout


def test_two_speakers_have_statistics_of_their_own_and_emotions_a_table(pair):
    coding = MarkerCoding.load(pair / "codings/markers/model.safetensors")
    assert coding.speakers == ("alex", "robin") and len(coding.mean) == 3
    assert abs(coding.mean[0] - coding.mean[1]).max() > 1  # pixels
    emotions = pandas.read_csv(pair / "sadoughi2017/tables/emotions.tsv", sep="\t", comment="#")
    assert set(emotions["emotion"]) >= {"neutral", "happiness"}
    assert (pair / "sadoughi2017/figures/emotions.png").read_bytes().startswith(b"\x89PNG")
    assert "by region of the face and emotion" in (pair / "report.html").read_text()


def test_every_file_is_described(run, pair):
    assert undescribed(run[0] / "results/tiny") == undescribed(pair) == []
