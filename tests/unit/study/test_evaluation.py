"""The evaluation of study folders: by hand, from end to end, marked where simulated, and with every bad input."""

import io
import shutil
import sqlite3
from contextlib import closing
from dataclasses import replace

import pandas
import pytest

from tests.unit.evaluation.nesting import check_nesting
from tests.unit.study.folders import (
    FIVE,
    preference_study,
    preferring,
    rating,
    rating_study,
    write_answers,
)
from visualspeech.cli import main
from visualspeech.errors import DataError, SettingError
from visualspeech.evaluation.study_contents import CONTENTS
from visualspeech.study.evaluation import evaluate, evaluation_files, summary, write_evaluation
from visualspeech.study.evaluation_settings import EvaluationSettings
from visualspeech.study.records import ANSWERS, KEY, SIMULATED_ANSWERS, STUDY, Condition, Stimulus, write_key

FAST = EvaluationSettings(samples=200, permutations=200)


def frame(evaluation, name):
    return next(part.frame for part in evaluation.parts if part.name == name)


def facts(evaluation):
    return dict(evaluation.parts[0].tables[0].facts)


def answers(*values):
    """Answers to the items i0, i1, ...: (what was on the screen, which stimulus)."""
    return [(f"i{number}", "preference", value, mirrored) for number, (value, mirrored) in enumerate(values)]


@pytest.fixture
def preference(tmp_path):
    study, key = preference_study(tmp_path / "fan")
    write_answers(tmp_path / "fan", study, preferring(study, key, 20, seed=8))
    return tmp_path / "fan"


@pytest.fixture
def ratings(tmp_path):
    study, key = rating_study(tmp_path / "sadoughi")
    write_answers(tmp_path / "sadoughi", study, rating(study, key, 20))
    return tmp_path / "sadoughi"


def test_answers_are_counted_by_what_was_on_the_screen(tmp_path):
    """i0 and i2 have the first condition on the left of their first stimulus, i1 on the right."""
    study, _ = preference_study(tmp_path, sentences=3, attention=0)
    write_answers(
        tmp_path,
        study,
        {
            "A": answers(("left", 0), ("left", 0), ("none", 0)),  # first, second, none
            "B": answers(("left", 1), ("left", 1), ("right", 1)),  # second, first, first
            "C": answers(("left", 0), ("right", 0), ("right", 0)),  # first, first, second
        },
    )
    found = evaluate(tmp_path, settings=FAST)
    shares = frame(found, "preference").query("answers == 'people'").set_index("answer")
    assert shares["count"].to_dict() == {"blstm": 5, "none": 1, "hmm": 3}
    assert shares["sentences"].to_dict() == {"blstm": 2, "none": 1, "hmm": 0}
    votes = frame(found, "sentences")
    assert votes[["utterance", "count_first", "count_none", "count_second", "majority"]].values.tolist() == [
        ["s00", 2, 0, 1, "blstm"],
        ["s01", 2, 0, 1, "blstm"],
        ["s02", 1, 1, 1, "tie"],
    ]
    assert facts(found)["answers for the left video"].startswith("62.5% ")
    said = dict(found.parts[1].tables[0].facts)["majority of viewers"]
    assert said == "deep BLSTM 2, HMM 0; one is a tie (3 sentences)"
    tests = {row.title.split(":")[0]: [cell.text for cell in row.cells] for row in found.parts[0].tables[1].rows}
    assert tests == {
        "answers": ["5", "8", "62.5%", "0.7266"],  # 2 (C(8, 5) + C(8, 6) + C(8, 7) + 1) / 2^8
        "participants": ["", "3", "", "0.5000"],  # differences 0, 1/3, 1/3: 2 of 8 sign patterns on either side
        "sentences by majority": ["2", "2", "100.0%", "0.5000"],
    }


def test_the_published_preference_is_recovered_from_a_folder(preference):
    """61.5 / 15.5 / 23.0 per cent, as simulated, lie in all intervals."""
    found = frame(evaluate(preference, settings=FAST), "preference").query("answers == 'people'")
    for line, true in zip(found.itertuples(), (0.615, 0.155, 0.23), strict=True):
        assert line.low < true < line.high and line.participants_low < true < line.participants_high
    assert (found["p"] < 0.001).all() and (found["p_participants"] < 0.02).all()


def test_published_figures_stand_beside_and_are_marked(preference, ratings, tmp_path):
    found = evaluate(preference, settings=FAST)
    titles = [table.title for table in found.parts[0].tables]
    assert titles == ["deep BLSTM against HMM", "Tests of deep BLSTM against HMM", "Preference test as published"]
    assert [cell.text for cell in found.parts[0].tables[2].rows[0].cells] == ["61.5%", "15.5%", "23.0%"]
    printed = frame(found, "preference").query("answers == 'published'")
    assert printed["share"].tolist() == [0.615, 0.155, 0.23] and printed["count"].isna().all()
    assert "hatched: as published" in found.drawings[0].picture.caption
    tests = next(part for part in evaluate(ratings, settings=FAST).parts if part.name == "rating_tests")
    assert tests.tables[1].title == "Ratings as published" and tests.tables[1].rows[0].cells[0].text == "0.6720"
    study, key = preference_study(tmp_path / "forced", sentences=20, forced=True, published="thangthai2016")
    write_answers(tmp_path / "forced", study, preferring(study, key, 15, (0.7, 0, 0.3)))
    found = evaluate(tmp_path / "forced", settings=FAST)
    assert found.parts[0].tables[2].rows[0].title == "sentences by majority"
    assert [cell.text for cell in found.parts[0].tables[2].rows[0].cells] == ["80.0%"]
    study, key = preference_study(tmp_path / "own", published="")
    write_answers(tmp_path / "own", study, preferring(study, key, 4))
    own = evaluate(tmp_path / "own", settings=FAST)
    assert len(own.parts[0].tables) == 2 and "published" not in own.drawings[0].picture.caption


def test_a_forced_choice_has_no_neutral_column_and_says_ties(tmp_path):
    study, key = preference_study(tmp_path, sentences=4, attention=0, forced=True, published="")
    first = answers(("left", 0), ("right", 0), ("left", 0), ("right", 0))
    second = answers(("right", 0), ("right", 0), ("left", 0), ("right", 0))
    write_answers(tmp_path, study, {"A": first, "B": second})
    found = evaluate(tmp_path, settings=FAST)
    table = found.parts[0].tables[0]
    assert table.columns == ("deep BLSTM", "HMM") and "no difference" not in str(table)
    assert [cell.text for cell in table.rows[0].cells] == ["87.5%", "12.5%"]
    assert "one is a tie, which its test leaves out." in found.parts[0].tables[1].notes[1]
    assert "no difference" not in str(found.parts[0].tables)
    assert [row.cells[-1].text for row in found.parts[1].tables[0].rows] == ["tie", *["deep BLSTM"] * 3]


def test_a_key_that_compares_something_else_is_refused(tmp_path):
    third = Condition("mean", "training mean", "fan2015", "training_mean")
    study, key = preference_study(tmp_path, sentences=2, attention=0)
    write_answers(tmp_path, study, preferring(study, key, 2))
    write_key(tmp_path, replace(key, conditions=(*key.conditions, third)))
    with pytest.raises(DataError, match="compares two conditions, not 3. Make the study again"):
        evaluate(tmp_path, settings=FAST)
    odd = {**key.stimuli, "v1a.mp4": Stimulus("i1", "s01", ("blstm", "mean"))}
    write_key(tmp_path, replace(key, stimuli=odd))
    with pytest.raises(DataError, match="the item i1 does not compare blstm and hmm"):
        evaluate(tmp_path, settings=FAST)
    study, key = rating_study(tmp_path / "rating", turns=1, conditions=FIVE[:2])
    write_answers(tmp_path / "rating", study, rating(study, key, 2, means=(5, 5)))
    odd = {**key.stimuli, "v0joint1.mp4": Stimulus("i0joint1", "t00", ("joint9",))}
    write_key(tmp_path / "rating", replace(key, stimuli=odd))
    with pytest.raises(DataError, match="the item i0joint1 does not show one of the conditions"):
        evaluate(tmp_path / "rating", settings=FAST)


def test_ratings_belong_to_their_conditions(tmp_path):
    study, key = rating_study(tmp_path, turns=2, conditions=FIVE[:2])
    rows = [
        (item.id, question.name, {"original": 9, "joint1": 4}[key.stimuli[item.stimuli[0]].conditions[0]] + shift, 0)
        for item in study.of_role("item")
        for shift, question in enumerate(study.questions, -1)
    ]
    write_answers(tmp_path, study, {"A": rows, "B": [(*row[:2], row[2] - 1, 0) for row in rows]})
    found = evaluate(tmp_path, settings=FAST)
    means = frame(found, "ratings").set_index(["question", "condition"])["mean"]
    assert means.to_dict() == {
        (question, condition): mean + shift - 0.5
        for shift, question in enumerate(("overall", "eyebrows", "lips"), -1)
        for condition, mean in (("original", 9), ("joint1", 4))
    }
    assert frame(found, "pairs")["difference"].tolist() == [5.0] * 3
    # Every rater has the same order of the videos.
    assert frame(found, "rating_tests")["alpha"].to_list()[0] == pytest.approx(1)


def test_the_result_of_sadoughi_and_busso_is_found(ratings):
    """The first condition is rated higher than the four others, and has their four stars for each question."""
    found = evaluate(ratings)
    pairs = frame(found, "pairs")
    assert ((pairs["p_tukey"] < 0.01) == (pairs["first"] == "original")).all()
    tests = frame(found, "rating_tests").query("question != 'all'")
    assert (tests["f_p"] < 0.001).all() and (tests["f_between"] == 4).all() and (tests["f_within"] == 995).all()
    assert tests["raters"].tolist() == [20] * 3 and tests["cases"].tolist() == [50] * 3
    assert frame(found, "rating_tests")["cases"].iloc[-1] == 150


def test_who_is_left_out_is_listed(tmp_path):
    study, key = preference_study(tmp_path, sentences=4, attention=2)
    people = preferring(study, key, 6)
    codes = list(people)
    people[codes[1]] = people[codes[1]][:2]
    people[codes[2]] = people[codes[2]][:-1]
    people[codes[3]][-1] = ("a1", "preference", "right", 0)
    people[codes[4]] = []
    write_answers(tmp_path, study, people)
    found = evaluate(tmp_path, settings=FAST)
    listed = frame(found, "participants").set_index("code")
    assert listed["reason"].tolist() == [
        "", "stopped early", "stopped early", "failed attention items", "answered no item", "",
    ]  # fmt: skip
    assert listed.loc[codes[2], ["answered", "unanswered", "failed"]].tolist() == [4, 1, 0]
    assert frame(found, "preference")["count"].dropna().sum() == 2 * 4
    table = found.parts[-1].tables[0]
    assert [row.title for row in table.rows] == codes[1:5]
    assert table.notes[0] == "Participants who answered every item, and all attention items as asked, are counted."
    assert facts(found)["participants"] == "2 counted, 4 left out"
    lenient = evaluate(tmp_path, settings=EvaluationSettings(samples=200, permutations=200, max_failed_attention=1))
    assert facts(lenient)["participants"] == "3 counted, 3 left out"
    assert "all attention items but 1 at most as asked" in lenient.parts[-1].tables[0].notes[0]


def test_simulated_answers_are_asked_for_marked_everywhere_and_never_mixed(tmp_path):
    study, key = preference_study(tmp_path)
    write_answers(tmp_path, study, preferring(study, key, 5, (1, 0, 0)))
    write_answers(tmp_path, study, preferring(study, key, 7, (0, 0, 1)), simulated=True)
    people, simulated = evaluate(tmp_path, settings=FAST), evaluate(tmp_path, True, FAST)
    assert frame(people, "preference")["share"].tolist()[:3] == [1, 0, 0]
    assert frame(simulated, "preference")["share"].tolist()[:3] == [0, 0, 1]
    files, marked = evaluation_files(people), evaluation_files(simulated)
    assert set(files) == set(marked)
    for name, content in marked.items():
        if name.endswith(".png"):
            assert content != files[name]
        else:
            assert b"imulated" in content and (b"SIMULATED" in content or name == CONTENTS), name
            assert b"imulated" not in files[name], name
    for part in simulated.parts:
        own = [table for table in part.tables if "as published" not in table.title]
        assert own and all(table.title.startswith("Simulated answers: ") for table in own)
        assert set(part.frame["answers"]) - {"published"} == {"simulated"}
    assert all(one.picture.caption.startswith("Simulated answers: ") for one in simulated.drawings)
    assert summary(simulated).startswith("Simulated answers: ") and "imulated" not in summary(people)


@pytest.mark.parametrize("kind", ["preference", "ratings"])
def test_files_are_whole_repeat_and_nest(kind, request, tmp_path):
    folder = request.getfixturevalue(kind)
    found = evaluate(folder, settings=FAST)
    files = evaluation_files(found)
    assert files == evaluation_files(evaluate(folder, settings=FAST))
    for name, content in files.items():
        if name.endswith(".html"):
            text = content.decode()
            check_nesting(text)
            assert "http" not in text.replace("http-equiv", "") and "<script" not in text
        if name.endswith(".tex"):
            assert content.decode().count(r"\begin{table}") == content.decode().count(r"\end{table}") > 0, name
        if name.endswith(".tsv"):
            lines = [line for line in content.decode().splitlines() if not line.startswith("#")]
            assert len(pandas.read_csv(io.StringIO("\n".join(lines)), sep="\t")) == len(lines) - 1
    write_evaluation(tmp_path / "out", found)
    assert {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()} == files
    write_evaluation(tmp_path / "out", found)
    assert sorted(path.name for path in tmp_path.glob("*out*")) == ["out"]


def test_a_folder_with_other_files_is_not_replaced(preference, tmp_path):
    found = evaluate(preference, settings=FAST)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("years of work")
    for folder in (tmp_path / "mine", tmp_path / "mine" / "thesis.tex", preference):
        with pytest.raises(SettingError, match="give"):
            write_evaluation(folder, found)
    assert (tmp_path / "mine" / "thesis.tex").read_text() == "years of work" and (preference / KEY).is_file()


def test_one_participant_and_ratings_without_variance_are_said(tmp_path):
    study, key = preference_study(tmp_path / "one")
    write_answers(tmp_path / "one", study, preferring(study, key, 1))
    found = evaluate(tmp_path / "one", settings=FAST)
    assert any("One participant alone counts" in note for note in found.parts[0].tables[0].notes)
    assert [cell.text for cell in found.parts[0].tables[1].rows[1].cells] == ["", "1", "", ""]
    assert [cell.text for cell in found.parts[0].tables[0].rows[1].cells] == ["", "", ""]
    study, key = rating_study(tmp_path / "flat", turns=2)
    rows = [(item.id, question.name, 5, 0) for item in study.of_role("item") for question in study.questions]
    write_answers(tmp_path / "flat", study, {"A": rows, "B": rows})
    found = evaluate(tmp_path / "flat", settings=FAST)
    notes = found.parts[1].tables[0].notes
    assert "All 20 ratings of “lips” are 5: there is no variance, and neither agreement nor tests are defined." in notes
    assert [cell.text for cell in found.parts[1].tables[0].rows[0].cells] == [""] * 5
    assert evaluation_files(found)["ratings.png"].startswith(b"\x89PNG")


def damage(folder, what):
    """Damage a copy of a study folder."""
    database = folder / ANSWERS
    if what == "no answers":
        database.unlink()
    elif what == "only simulated":
        shutil.move(database, folder / SIMULATED_ANSWERS)
    elif what == "no key":
        (folder / KEY).unlink()
    elif what == "no study":
        (folder / STUDY).unlink()
    elif what == "damaged key":
        (folder / KEY).write_text("{")
    elif what == "damaged study":
        (folder / STUDY).write_text('{"version": 1}')
    elif what == "no database":
        database.write_bytes(b"SQLite format 3\0" + bytes(range(256)) * 40)
    elif what == "cut off":
        database.write_bytes(database.read_bytes()[:9000])
    elif what == "a text":
        database.write_text("listener\tpair\tanswer\n")
    else:
        with closing(sqlite3.connect(database)) as one, one:
            one.execute(what)


BAD = [
    ("no answers", "holds no answers of people yet"),
    ("only simulated", "There are simulated answers, which --simulated evaluates."),
    ("no key", "key.json"),
    ("no study", "holds no study"),
    ("damaged key", "key.json: it is no JSON"),
    ("damaged study", "study.json"),
    ("no database", "answers.sqlite"),
    ("cut off", "answers.sqlite"),
    ("a text", "answers.sqlite"),
    ("UPDATE study SET digest = 'x'", "the study was made again since, or files of two studies were mixed"),
    ("UPDATE study SET simulated = 1", "does not hold answers of people"),
    ("UPDATE answers SET item = 'zz' WHERE rowid = 3", "an answer to the item 'zz', which is not in the study"),
    ("UPDATE answers SET question = 'zz' WHERE rowid = 3", "an answer to the question 'zz'"),
    ("UPDATE answers SET value = 'up' WHERE rowid = 3", "the answer 'up' to the question 'preference'"),
    ("UPDATE answers SET value = x'00ff' WHERE rowid = 3", "which does not allow it"),
    ("UPDATE answers SET mirrored = 7 WHERE rowid = 3", "an answer to a video of the item"),
    ("DELETE FROM participants WHERE id = 2", "an answer of a participant 2 who is not in its list"),
    ("DELETE FROM answers", "holds no answers of people yet (answers.sqlite); 20 participants have begun"),
    ("DELETE FROM answers WHERE item = 'i3'", "none of the 20 participants counts (20 stopped early)"),
    ("UPDATE answers SET value = 'right' WHERE item = 'a0'", "counts (20 failed attention items)"),
    ("DROP TABLE answers", "answers.sqlite"),
]


@pytest.mark.parametrize(("what", "message"), BAD, ids=[what for what, _ in BAD])
def test_bad_input_is_one_sentence_and_nothing_is_written(preference, what, message, capsys):
    damage(preference, what)
    before = sorted(path.name for path in preference.iterdir())
    assert main(["study", "evaluate", str(preference)]) == 1
    said = capsys.readouterr()
    assert said.out == "" and message in said.err and said.err.count("\n") == 1
    assert "unexpected" not in said.err and "Traceback" not in said.err
    assert sorted(path.name for path in preference.iterdir()) == before


def test_ratings_that_are_no_numbers(ratings, capsys):
    damage(ratings, "UPDATE answers SET value = 'good' WHERE rowid = 3")
    assert main(["study", "evaluate", str(ratings)]) == 1
    said = capsys.readouterr().err
    assert "answers.sqlite holds a rating that is no number." in said and said.count("\n") == 1


@pytest.mark.parametrize("options", [["--max-failed-attention", "-1"], ["-o", "FOLDER"]])
def test_wrong_options(preference, options, capsys, tmp_path):
    options = [str(preference) if one == "FOLDER" else one for one in options]
    assert main(["study", "evaluate", str(preference), *options]) == 2
    assert "give" in capsys.readouterr().err


def test_the_command_writes_and_says_where(preference, capsys, tmp_path):
    assert main(["study", "evaluate", str(preference)]) == 0
    said = capsys.readouterr()
    assert "share of answers: deep BLSTM" in said.out and "Preference test as published" in said.out
    assert str(preference / "evaluation" / "evaluation.html") in said.err
    assert (preference / "evaluation" / "preference.png").is_file()
    assert main(["study", "evaluate", str(preference), "--simulated"]) == 1
    assert "holds no simulated answers" in capsys.readouterr().err
    assert main(["study", "evaluate", str(preference), "-o", str(tmp_path / "deep" / "out")]) == 0
    assert (tmp_path / "deep" / "out" / "evaluation.html").is_file()
