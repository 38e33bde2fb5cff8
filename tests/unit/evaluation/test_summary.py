"""The last lines of a run."""

import pytest

from tests.unit.evaluation.examples import BASELINES, hmm, stack, statistics
from visualspeech.corpora.findings import REJECT, UNLISTED, WARN, Finding, write_findings
from visualspeech.evaluation.summary import failed, finished, guessed_words, speak_commands, study_commands
from visualspeech.progress import Failed
from visualspeech.storage.tables import write_table


@pytest.fixture
def corpus(tmp_path):
    """A corpus with two seeds of a network and an HMM, as the workflow describes it."""
    rows = [stack("F-8-s1", "F", 8, cell="F-8"), stack("F-8-s2", "F", 8, cell="F-8"), hmm("hmm", "HMM")]
    rows.append(BASELINES["training_mean"])
    # The best single seed is a network; on average over its seeds the network is worse than the HMM.
    errors = {"F-8-s1": 1.0, "F-8-s2": 2.0, "hmm": 1.2, "training_mean": 0.1}
    paths = {name: str(tmp_path / f"{name}.tsv") for name in errors}
    for name, error in errors.items():
        write_table(paths[name], statistics([error, error]))
    findings = tmp_path / "findings.tsv"
    write_findings(findings, [
        Finding("a", "check", REJECT, "a.mp4", "silent"),
        Finding("a", "pose", REJECT, "a.mp4", "no face"),
        Finding("b", "check", WARN, "b.mp4", f"{UNLISTED}fluxo, zorb"),
        Finding("c", "check", WARN, "c.mp4", f"{UNLISTED}zorb"),
    ])  # fmt: skip
    (tmp_path / "report.html").write_text("x")
    system = {"name": "fan2015", "rows": [row.plain() for row in rows], "validation": paths}
    return {"name": "demo", "report": str(tmp_path / "report.html"), "findings": [str(findings)], "utterances": 9,
            "systems": [system]}  # fmt: skip


def test_five_lines(corpus):
    lines = finished([corpus], ["visualspeech speak"])
    assert [line.split(":")[0] for line in lines] == ["Report", "Best model", "Rejected", "Guessed words", "Next"]
    assert lines[1].endswith("fan2015 hmm (RMSE(appearance)), by the validation utterances")
    assert f"1 of 9 utterances, see {corpus['findings'][0]}" in lines[2]
    assert lines[3].endswith("2 (fluxo, zorb), pronounced by letter-to-sound rules")


def test_what_the_target_did_not_make_is_left_out(corpus, tmp_path):
    bare = corpus | {"report": str(tmp_path / "no"), "findings": [str(tmp_path / "no")], "systems": []}
    assert finished([bare], []) == []
    lines = finished([bare | {"findings": corpus["findings"]}], ["a", "b"])
    assert [line.split()[0] for line in lines] == ["Rejected:", "Guessed", "Next:", "b"]


def test_several_corpora_are_told_apart(corpus, tmp_path):
    other = corpus | {"name": "second", "report": str(tmp_path / "none")}
    text = "\n".join(finished([corpus, other], []))
    assert "demo/fan2015 hmm" in text and "second/fan2015 hmm" in text and "utterances of second" in text
    assert max(map(len, text.splitlines())) < 160


def test_words_are_listed_once_and_cut(tmp_path):
    path = str(tmp_path / "findings.tsv")
    words = ", ".join(f"w{number}" for number in range(20))
    write_findings(path, [Finding("a", "check", WARN, "", UNLISTED + words)])
    assert len(guessed_words([path, str(tmp_path / "none")])) == 20
    (line,) = (one for one in finished([{"name": "x", "report": "", "findings": [path], "utterances": 1,
                                         "systems": []}], []) if one.startswith("Guessed"))  # fmt: skip
    assert "20 (w0" in line and "and 10 more" in line


def test_a_failure_names_job_message_log_and_remedy(tmp_path):
    log = tmp_path / "0.log"
    log.write_text("12:00:00 check_recordings 0: 4 of 4 utterances cannot be used\n  a.mp4: silent.\n")
    lines = failed([Failed("check_recordings", {"shard": "0"}, (str(log),))], 3, 40)
    assert lines == [
        "The run failed in check_recordings (shard 0).",
        "  4 of 4 utterances cannot be used",
        "    a.mp4: silent.",
        f"  Log: {log}",
        "3 of 40 jobs are done. When this is corrected, run the same command again: what is done is kept.",
    ]
    several = failed([Failed(f"rule{number}", {}) for number in range(9)], 0, 0)
    assert several[0] == "The run failed in 9 jobs." and "  and 4 further jobs" in several
    assert "Its message is above." in several[2]
    log.write_text("12:00:00 train_model a: stopped (SIGTERM); run the same command again to resume\n")
    said = ["The run was stopped. 3 of 40 jobs are done. Run the same command again to resume."]
    stopped = Failed("train_model", {}, (str(log),))
    assert failed([stopped], 3, 40) == failed([], 3, 40) == said


def test_what_to_type_next(monkeypatch):
    monkeypatch.setattr("shutil.which", lambda name: f"/bin/{name}")
    typed = ["/bin/snakemake", "--cores", "2", "all", "--configfile", "my file.yaml", "-F", "-R", "x", "y"]
    first, second = speak_commands("results/demo/x", False, typed, {"all"})
    assert first == "snakemake speaker --cores 2 --configfile 'my file.yaml'"
    assert second == 'visualspeech speak --model results/demo/x --text "Hello." -o hello.mp4'
    assert speak_commands("results/demo/x", True, typed, {"all"}) == [second]
    assert (
        speak_commands("x", False, ["/a/__main__.py", "--cores", "1"], ())[0] == "python -m snakemake speaker --cores 1"
    )
    monkeypatch.setattr("shutil.which", lambda name: None)
    monkeypatch.chdir("/")
    assert speak_commands("x", True, ["/a/bin/snakemake"], ())[0].startswith("a/bin/visualspeech speak")


def test_what_to_type_after_a_study(monkeypatch):
    monkeypatch.setattr("shutil.which", lambda name: None)
    monkeypatch.chdir("/")
    typed = ["/a/bin/snakemake", "study"]
    assert study_commands(["results/demo/studies/my test"], typed) == [
        "a/bin/visualspeech study serve 'results/demo/studies/my test'",
        "a/bin/visualspeech study evaluate 'results/demo/studies/my test'",
    ]
    assert study_commands(["a", "b"], typed) == [
        "a/bin/visualspeech study serve a",
        "a/bin/visualspeech study serve b",
        "a/bin/visualspeech study evaluate FOLDER",
    ]
    assert study_commands([], typed) == []
