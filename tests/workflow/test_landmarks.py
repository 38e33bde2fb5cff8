"""Landmarks that users bring, through the command line: a tracker of their own, and files of another program."""

import shutil

import pytest
import yaml

from tests import synthetic
from tests.unit.face.openface import moving, rows, write
from tests.workflow.running import snakemake
from visualspeech.corpora.findings import read_findings
from visualspeech.storage.arrays import ArrayReader

pytestmark = pytest.mark.xdist_group("workflow")

NAMES = ["a", "b", "c"]
LANDMARKS = "results/mine/landmarks/0.h5"
TRACKER = '''"""A tracker of one's own."""

import numpy as np


class Mine:
    def __init__(self, settings, video):
        self.still = np.random.default_rng(len(video.path)).uniform(20, 90, (68, 2))

    def next(self, frame, number):
        return self.still + 0.1 * number
'''


@pytest.fixture
def corpus(tmp_path):
    """Folder of recordings, and a function that writes the overlay with settings of the landmarks."""
    source = synthetic.record(tmp_path / "source.mp4", 1.0)
    root = tmp_path / "clips"
    root.mkdir()
    for name in NAMES:
        shutil.copy(source, root / f"{name}.mp4")
        (root / f"{name}.txt").write_text("bin blue at f two now")
    one = {"name": "mine", "adapter": "folder", "root": str(root), "consent": "Nobody's face."}
    path = tmp_path / "settings" / "mine.yaml"
    path.parent.mkdir()
    screening = {"max_frame_change": 255, "max_landmark_step": 10}

    def overlay(**landmarks):
        settings = {"corpora": [one], "shards": 1, "max_rejected_share": 1, "screening": screening}
        path.write_text(yaml.safe_dump({**settings, "landmarks": {"smoothing": 0, **landmarks}}))
        return path

    return root, overlay


def planned(folder, path):
    done = snakemake(folder, "--dry-run", LANDMARKS, configfiles=(path,))
    assert done.returncode == 0, done.stdout
    return {line.split()[1].rstrip(":") for line in done.stdout.splitlines() if line.startswith("rule ")}


def test_a_tracker_beside_the_settings_tracks_and_tracks_again_when_it_changes(corpus, tmp_path):
    _, overlay = corpus
    path = overlay(tracker="mine:Mine")
    done = snakemake(tmp_path, LANDMARKS, configfiles=(path,), cores=1)
    assert done.returncode != 0 and "`landmarks.tracker: mine:Mine`: there is no module mine" in done.stdout
    (path.parent / "mine.py").write_text(TRACKER)
    done = snakemake(tmp_path, LANDMARKS, configfiles=(path,), cores=1)
    assert done.returncode == 0, done.stdout[-4000:]
    with ArrayReader(tmp_path / LANDMARKS) as found:
        points = found.array("a", "points")
        assert found.ids == NAMES and points.shape == (25, 68, 2)
        assert abs(points[10] - points[0] - 1).max() < 1e-3
    assert planned(tmp_path, path) == set()
    (path.parent / "mine.py").write_text(TRACKER.replace("0.1", "0.2"))
    assert planned(tmp_path, path) == {"track_landmarks"}
    (path.parent / "mine.py").write_text(TRACKER.replace("return self.still + 0.1 * number", "return [1, 2]"))
    done = snakemake(tmp_path, LANDMARKS, configfiles=(path,), cores=1)
    assert done.returncode != 0 and "`next` returned an array of the shape (2,) for frame 0 of" in done.stdout
    assert "Traceback" not in done.stdout


def test_code_of_a_corpus_is_never_run(corpus, tmp_path):
    root, overlay = corpus
    (root / "theirs.py").write_text(f"open({str(tmp_path / 'pwned')!r}, 'w')\n" + TRACKER)
    settings = overlay(tracker="theirs:Mine")
    stranger = shutil.copy(settings, root / "overlay.yaml")
    done = snakemake(tmp_path, LANDMARKS, configfiles=(stranger,), cores=1)
    assert done.returncode != 0 and "lies among the recordings" in done.stdout
    corpus_file = root / "corpus.yaml"
    named = yaml.safe_load(settings.read_text())["corpora"][0] | {"landmarks": {"tracker": "theirs:Mine"}}
    corpus_file.write_text(yaml.safe_dump(named))
    settings.write_text(yaml.safe_dump({"corpora": [str(corpus_file)], "shards": 1}))
    done = snakemake(tmp_path, LANDMARKS, configfiles=(settings,), cores=1)
    assert done.returncode != 0 and "landmarks" in done.stdout and "unknown setting" in done.stdout
    assert not (tmp_path / "pwned").exists()


def test_files_of_openface_are_read_and_a_bad_one_rejects_its_utterance(corpus, tmp_path):
    _, overlay = corpus
    path = overlay(source="csv", folder="openface")
    done = snakemake(tmp_path, LANDMARKS, configfiles=(path,), cores=1)
    assert done.returncode != 0 and "`landmarks.folder: openface` does not exist" in done.stdout
    points = moving(25) * (128 / 200, 96 / 160)
    for name in NAMES[:2]:
        write(tmp_path / "openface" / f"{name}.csv", rows(points))
    write(tmp_path / "openface" / "b.csv", [[1, 2, 3]])
    done = snakemake(tmp_path, LANDMARKS, configfiles=(path,), cores=1)
    assert done.returncode == 0, done.stdout[-4000:]
    with ArrayReader(tmp_path / LANDMARKS) as found:
        assert found.ids == ["a"]
        assert abs(found.array("a", "points") - points).max() < 1e-3
    told = {one.id: one.finding for one in read_findings(tmp_path / LANDMARKS.replace(".h5", ".findings.tsv"))}
    assert told["b"].startswith("line 2 of the landmark file b.csv has 3 values")
    assert told["c"] == "no landmark file openface/c.csv"
    assert planned(tmp_path, path) == set()
    write(tmp_path / "openface" / "c.csv", rows(points))
    assert planned(tmp_path, path) == {"track_landmarks"}
