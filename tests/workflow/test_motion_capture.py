"""Corpora of motion capture are listed, checked and read; every bad utterance costs itself alone."""

import numpy as np
import pytest

from tests.described_files import undescribed
from tests.motion_capture import LIVE_LINK, MARKERS, IemocapTree, moving, write_live_link, write_mocap, write_wav
from tests.workflow.running import overlay, snakemake
from visualspeech.corpora.findings import read_findings
from visualspeech.corpora.table import read_utterances
from visualspeech.face.markers import read_marker_set
from visualspeech.storage.arrays import ArrayCollection

pytestmark = pytest.mark.xdist_group("motion_capture")


def iemocap(root):
    """A tree with a good session and one bad turn of each sort; returns turn -> what is said of it."""
    tree = IemocapTree(root, sessions=(1,), labels=("neu", "ang", "sad", "exc", "xxx", "neu", "sad"), unrated=True)
    points = moving(1.6, len(MARKERS))
    never, hidden = points.copy(), points.copy()
    never[:, MARKERS.index("CH2")] = np.nan
    hidden[30:90, MARKERS.index("Mou3")] = np.nan
    turn = "Ses01F_impro01_F00{}".format
    write_mocap(tree.motion(turn(0)), never)
    write_mocap(tree.motion(turn(1)), hidden)
    write_mocap(tree.motion(turn(2)), points[:2])
    write_mocap(tree.motion(turn(3)), points[:100])
    silent, unrated = "Ses01M_script01_1_M000", "Ses01M_script01_1_M006"
    tree.sound(silent).unlink()
    return {
        turn(0): "a marker is never visible: CH2",
        turn(1): "the marker Mou3 is occluded for 0.50 s from 0.25 s on, longer than `motion.max_gap: 0.25`",
        turn(2): "only 2 frames of motion capture",
        turn(3): "sound and motion capture differ in length: 1.60 s of sound, 0.83 s of motion capture",
        turn(6): f"the emotion file Ses01F_impro01.txt does not hold the turn {turn(6)}",
        unrated: f"the emotion file {unrated[:-5]}.txt does not hold the turn {unrated}",
        silent: f"no sound: there is no file sentences/wav/{silent[:-5]}/{silent}.wav",
    }


def live_link(root):
    """Recordings of Live Link Face, three of them good; returns id -> what is said."""
    names = [f"u{number}" for number in range(8)]
    for number, name in enumerate(names):
        write_live_link(root / f"{name}.csv", unseen=(20, 21))
        write_wav(root / f"{name}.wav", 1.6, 100.0 + 10 * number)

    def edit(name, change):
        path = root / f"{name}.csv"
        path.write_text("\n".join(change(path.read_text().splitlines())) + "\n")

    edit("u3", lambda lines: [*lines[:9], lines[9].rpartition(",")[0], *lines[10:]])
    edit("u4", lambda lines: [lines[0].replace(",JawOpen", ",Jaw"), *lines[1:]])
    edit("u5", lambda lines: [*lines[:9], lines[8], *lines[9:]])
    edit("u6", lambda lines: lines[:3])
    write_wav(root / "u7.wav", 3.0)
    count = len(LIVE_LINK) + 2
    return {
        "u3": f"u3.csv, line 10: the row has {count - 1} cells, the first line names {count} columns",
        "u4": "u4.csv lacks 1 of 52 columns: JawOpen",
        "u5": "u5.csv, line 10: its time, 0.1167 s after the first row, repeats that of line 9",
        "u6": "only 2 frames of motion capture",
        "u7": "sound and motion capture differ in length: 3.00 s of sound, 1.60 s of motion capture",
    }


def test_motion_capture_is_read_and_bad_utterances_cost_themselves(tmp_path):
    said = {"iemocap": iemocap(tmp_path / "IEMOCAP"), "live": live_link(tmp_path / "live")}
    corpora = [
        {"name": "iemocap", "adapter": "iemocap", "root": str(tmp_path / "IEMOCAP"), "transcripts": False},
        {"name": "live", "adapter": "mocap", "root": str(tmp_path / "live")},
    ]
    changes = {"corpora": corpora, "systems": ["fan2015", "sadoughi2017"], "max_rejected_share": 0.9, "shards": 1}
    files = overlay(tmp_path, changes)
    targets = [f"results/{name}/utterances.tsv" for name in said]
    done = snakemake(tmp_path, *targets, configfiles=files)
    assert done.returncode == 0, done.stdout[-4000:]
    assert "Traceback" not in done.stdout
    for name in said:
        assert f"fan2015 is skipped on {name}: it needs video of every utterance" in done.stdout
        findings = {one.id: one for one in read_findings(tmp_path / f"results/{name}/findings.tsv")}
        assert {one: found.finding.partition(" (")[0] for one, found in findings.items()} == said[name]
        assert all(found.file and found.remedy.endswith(".") for found in findings.values())
        rejected = {one for one, found in findings.items() if found.level == "reject"}
        accepted = read_utterances(tmp_path / f"results/{name}/utterances.tsv")
        with ArrayCollection([tmp_path / f"results/{name}/motion/0.h5"]) as motion:
            assert {one.id for one in accepted} == set(motion.ids) and not rejected & set(motion.ids)
            assert len(accepted) == {"iemocap": 14, "live": 8}[name] - len(rejected)
            markers = read_marker_set({"iemocap": "iemocap_46", "live": "live_link"}[name])
            shape, rate = {"iemocap": ((192, 46, 3), 120), "live": ((96, 52, 1), 60)}[name]
            for one in motion.ids:
                points = motion.array(one, "points")
                assert points.shape == shape and motion.rate(one) == rate and np.isfinite(points).all()
            assert markers.size == shape[1]
    warned = [one for one in read_findings(tmp_path / "results/iemocap/findings.tsv") if one.level == "warn"]
    assert [one.id for one in warned] == ["Ses01F_impro01_F006", "Ses01M_script01_1_M006"]
    emotions = {one.id: one.emotion for one in read_utterances(tmp_path / "results/iemocap/utterances.tsv")}
    assert emotions["Ses01F_impro01_F004"] == emotions["Ses01F_impro01_F006"] == ""
    assert emotions["Ses01M_script01_1_M001"] == "anger"
    assert undescribed(tmp_path / "results/iemocap") == undescribed(tmp_path / "results/live") == []
    again = snakemake(tmp_path, *targets, configfiles=files)
    assert again.returncode == 0 and "Nothing to be done" in again.stdout


def test_a_mistake_of_the_regions_is_reported_before_any_job(tmp_path):
    live_link(tmp_path / "live")
    corpus = {"name": "live", "adapter": "mocap", "root": str(tmp_path / "live"), "regions": {"forehead": ["JawOpen"]}}
    done = snakemake(tmp_path, "results/live/utterances.tsv", configfiles=overlay(tmp_path, {"corpora": [corpus]}))
    assert done.returncode != 0 and not (tmp_path / "results").exists()
    assert "`corpora.live.regions` has the unknown region 'forehead'; known are upper, middle, lower." in done.stdout
