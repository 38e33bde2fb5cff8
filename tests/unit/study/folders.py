"""Study folders with answers, as the server and the rule that makes a study write them."""

import sqlite3
from contextlib import closing
from pathlib import Path

import numpy as np

from visualspeech.study.layouts import ATTENTION, ITEM, LEFT, NONE, PRACTICE, PREFERENCE, RATING, RIGHT, TABLES
from visualspeech.study.records import (
    ANSWERS,
    SIMULATED_ANSWERS,
    Condition,
    Item,
    Key,
    Question,
    Stimulus,
    Study,
    write_key,
    write_study,
)

FIRST, SECOND = Condition("blstm", "deep BLSTM", "fan2015", "FBB-128"), Condition("hmm", "HMM", "fan2015", "hmm_mge")
FIVE = tuple(
    Condition(name, title, "sadoughi2017", model)
    for name, title, model in (
        ("original", "Original", ""), ("joint1", "Joint-1", "a"), ("joint2", "Joint-2", "b"),
        ("separate1", "Separate-1", "c"), ("separate2", "Separate-2", "d"),
    )
)  # fmt: skip


def preference_study(
    folder: Path, sentences=10, attention=1, forced=False, published="fan2015", conditions=None, corpus="demo"
):
    """A preference study; its second condition is on the left of the first stimulus of every other item."""
    conditions = (FIRST, SECOND)
    choices = (LEFT, RIGHT) if forced else (LEFT, NONE, RIGHT)
    items, stimuli, expected = [Item("p0", PRACTICE, ("vp0a.mp4", "vp0b.mp4"), 2.0)], {}, {}
    pair = (conditions[0].name, conditions[1].name)
    for file, shown in zip(items[0].stimuli, (pair, pair[::-1]), strict=True):
        stimuli[file] = Stimulus("p0", "practice", shown)
    for number in range(sentences):
        name, files = f"i{number}", (f"v{number}a.mp4", f"v{number}b.mp4")
        items.append(Item(name, ITEM, files, 2.0))
        orders = (pair, pair[::-1]) if number % 2 == 0 else (pair[::-1], pair)
        for file, shown in zip(files, orders, strict=True):
            stimuli[file] = Stimulus(name, f"s{number:02d}", shown)
    for number in range(attention):
        name = f"a{number}"
        items.append(Item(name, ATTENTION, (f"x{number}.mp4",), 2.0))
        stimuli[f"x{number}.mp4"] = Stimulus(name, "attention", (pair[0], pair[0]))
        expected[name] = {"preference": LEFT}
    study = Study(
        "fan2015", PREFERENCE, "Which?", "", "", (Question("preference", "Which is better?", choices),), tuple(items)
    )
    return _written(folder, study, conditions, stimuli, expected, published, corpus)


def rating_study(folder: Path, turns=10, attention=0, published="sadoughi2017", conditions=FIVE, scale=(1, 10)):
    """A rating study with three questions."""
    items, stimuli, expected = [Item("p0", PRACTICE, ("vp0.mp4",), 2.0)], {}, {}
    stimuli["vp0.mp4"] = Stimulus("p0", "practice", (conditions[0].name,))
    for number in range(turns):
        for condition in conditions:
            name, file = f"i{number}{condition.name}", f"v{number}{condition.name}.mp4"
            items.append(Item(name, ITEM, (file,), 2.0))
            stimuli[file] = Stimulus(name, f"t{number:02d}", (condition.name,))
    for number in range(attention):
        items.append(Item(f"a{number}", ATTENTION, (f"x{number}.mp4",), 2.0))
        stimuli[f"x{number}.mp4"] = Stimulus(f"a{number}", "attention", (conditions[0].name,))
        expected[f"a{number}"] = {"overall": scale[0]}
    questions = tuple(
        Question(name, f"How natural is {name}?", (), *scale, "low", "high") for name in ("overall", "eyebrows", "lips")
    )
    study = Study("sadoughi2017", RATING, "How natural?", "", "", questions, tuple(items))
    return _written(folder, study, conditions, stimuli, expected, published)


def _written(folder, study, conditions, stimuli, expected, published, corpus="demo"):
    folder.mkdir(parents=True, exist_ok=True)
    study = write_study(folder, study)
    key = Key(study.digest, corpus, "0123456789ab", 0, published, tuple(conditions), stimuli, expected)
    write_key(folder, key)
    return study, key


def answer_of(key, study, item, mirrored, condition):
    """The answer on the screen that prefers a condition, or none."""
    if condition == NONE:
        return NONE
    left, _ = key.stimuli[item.stimuli[mirrored]].conditions
    return LEFT if condition == left else RIGHT


def write_answers(folder: Path, study, people, simulated=False, finished=None):
    """Write a database: ``people`` is code -> (item id, question, value, mirrored) rows."""
    path = Path(folder, SIMULATED_ANSWERS if simulated else ANSWERS)
    path.unlink(missing_ok=True)
    with closing(sqlite3.connect(path)) as database, database:
        database.executescript(TABLES)
        database.execute("INSERT INTO study VALUES (?, ?)", (study.digest, int(simulated)))
        for number, (code, rows) in enumerate(people.items(), 1):
            done = "2026-01-01T10:20:00+00:00" if finished is None or code in finished else None
            start = "2026-01-01T10:00:00+00:00"
            database.execute(
                "INSERT INTO participants VALUES (?, ?, ?, ?, ?, ?, ?, ?)",
                (number, code, f"ticket-{code}", int(simulated), start, start, start, done),
            )
            for position, (item, question, value, mirrored) in enumerate(rows, 1):
                database.execute(
                    "INSERT INTO answers VALUES (?, ?, ?, ?, ?, ?, 1, ?)",
                    (number, item, question, str(value), position, mirrored, start),
                )
    return path


def preferring(study, key, people, shares=(0.615, 0.155, 0.23), seed=0):
    """Answers of participants who prefer the conditions of an item by given shares, and pass the attention items."""
    generator = np.random.default_rng(seed)
    found = {}
    for number in range(people):
        rows = []
        for item in study.of_role(ITEM):
            mirrored = int(generator.integers(2))
            first, second = (one.name for one in key.conditions[:2])
            liked = (first, NONE, second)[int(generator.choice(3, p=shares))]
            rows.append((item.id, "preference", answer_of(key, study, item, mirrored, liked), mirrored))
        rows += [(item.id, "preference", LEFT, 0) for item in study.of_role(ATTENTION)]
        found[f"P{number:03d}"] = rows
    return found


def rating(study, key, people, means=(7.5, 5.0, 5.1, 5.2, 4.9), spread=1.5, between=1.0, seed=0):
    """Ratings of participants around the means of the conditions, who differ from each other by ``between``."""
    generator = np.random.default_rng(seed)
    of_condition = dict(zip((one.name for one in key.conditions), means, strict=True))
    found = {}
    for number in range(people):
        own, rows = generator.normal(0, between), []
        for item in study.of_role(ITEM):
            mean = of_condition[key.stimuli[item.stimuli[0]].conditions[0]] + own
            for question in study.questions:
                value = int(np.clip(np.rint(generator.normal(mean, spread)), question.minimum, question.maximum))
                rows.append((item.id, question.name, value, 0))
        rows += [(item.id, q.name, q.minimum, 0) for item in study.of_role(ATTENTION) for q in study.questions]
        found[f"P{number:03d}"] = rows
    return found
