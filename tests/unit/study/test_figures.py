"""Figures of viewing tests: their colours, stars and marks, and that they repeat to the byte."""

import io

import numpy as np
from PIL import Image, ImageColor

from tests.unit.study.folders import FIVE, rating, rating_study, write_answers
from visualspeech.evaluation.plot_style import COLOURS
from visualspeech.evaluation.study_section import study_section
from visualspeech.study.evaluation import evaluate, write_evaluation
from visualspeech.study.evaluation_settings import EvaluationSettings
from visualspeech.study.figures import NEUTRAL, Bar, Rating, rating_bars, share_bars

SHARES = (COLOURS[0], NEUTRAL, COLOURS[1])
FAN = Bar("this study", ("BLSTM", "no difference", "HMM"), (0.615, 0.155, 0.23), ("61.5%", "15.5%", "23.0%"))


def area(png: bytes, colour: str) -> int:
    """Number of pixels of a colour."""
    pixels = np.asarray(Image.open(io.BytesIO(png)).convert("RGB"))
    return int((pixels == ImageColor.getrgb(colour)).all(axis=2).sum())


def test_areas_are_the_shares():
    png = share_bars([FAN], SHARES, "Preference")
    found = np.array([area(png, colour) for colour in SHARES], float)
    assert np.abs(found / found.sum() - FAN.shares).max() < 0.02  # the texts cover a part of each
    assert png == share_bars([FAN], SHARES, "Preference") != share_bars([FAN], SHARES, "Preference", simulated=True)


def test_published_bars_are_paler_and_unknown_shares_are_left_out():
    other = Bar("as published", FAN.labels, FAN.shares, FAN.texts, published=True)
    both, alone = share_bars([FAN, other], SHARES, "x"), share_bars([other], SHARES, "x")
    assert area(alone, COLOURS[0]) == 0 < area(both, COLOURS[0])
    empty = Bar("none", (), (np.nan, 0.0, 1.0), ("", "", "5"))
    assert area(share_bars([empty], SHARES, "$x_1$"), COLOURS[0]) == 0


def ratings(above=(), firm=()):
    low = [Rating(4.0, 3.5, 4.5), Rating(4.2, np.nan, np.nan)]
    return [[Rating(8.0, 7.5, 8.5, above, firm), *low]]


def test_stars_have_the_colour_of_the_lower_condition():
    names = ("original", "first", "second")
    plain, starred, hollow = (
        rating_bars(["lips"], names, ratings(*stars), (1, 10), "Ratings")
        for stars in (((), ()), ((2,), (2,)), ((2,), ()))
    )
    grown = [area(starred, colour) - area(plain, colour) for colour in COLOURS[:3]]
    assert grown[0] == grown[1] == 0 < grown[2]
    assert 0 < area(hollow, COLOURS[2]) - area(plain, COLOURS[2]) < grown[2]
    assert plain == rating_bars(["lips"], names, ratings(), (1, 10), "Ratings")
    assert plain != rating_bars(["lips"], names, ratings(), (1, 10), "Ratings", simulated=True)


def test_bars_begin_at_the_lowest_rating():
    """Ratings of 1 on a scale from 1 have no bar."""
    one = [[Rating(1.0, 1.0, 1.0), Rating(10.0, 10.0, 10.0)]]
    png = rating_bars(["overall"], ("a", "b"), one, (1, 10), "x")
    assert area(png, COLOURS[0]) < 0.05 * area(png, COLOURS[1])


def test_the_report_shows_what_an_evaluation_lists(tmp_path):
    study, key = rating_study(tmp_path / "study", turns=2, conditions=FIVE[:2])
    write_answers(tmp_path / "study", study, rating(study, key, 3, means=(8, 4)), simulated=True)
    found = evaluate(tmp_path / "study", True, EvaluationSettings(samples=100, permutations=100))
    write_evaluation(tmp_path / "corpus" / "evaluations" / "sadoughi2017", found)
    section = study_section(tmp_path / "corpus" / "evaluations" / "sadoughi2017", tmp_path / "corpus" / "report.html")
    assert section.title == "Simulated answers: viewing test sadoughi2017"
    assert section.page == "evaluations/sadoughi2017/evaluation.html"
    assert len(section.tables) == 4 and all("Simulated answers" in table.html for table in section.tables)
    assert section.tables[0].files[0].path == "evaluations/sadoughi2017/ratings.tsv"
    assert [one.picture for one in found.drawings] == list(section.figures)
