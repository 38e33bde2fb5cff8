"""Whole participations in a real browser: headless Chromium, on a desktop and on a phone."""

import os
import shutil

import pytest

from tests.unit.study import studies
from tests.unit.study.visitors import serving
from visualspeech.study.layouts import PREFERENCE, RATING
from visualspeech.study.records import read_answers, read_participants, read_study

SIZES = {
    "desktop": {"viewport": {"width": 1280, "height": 800}},
    "phone": {
        "viewport": {"width": 360, "height": 740},
        "is_mobile": True,
        "has_touch": True,
        "device_scale_factor": 2,
    },
}
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


@pytest.fixture(scope="module")
def browser():
    api = pytest.importorskip("playwright.sync_api", reason="Playwright is not installed")
    if CHROMIUM is None:
        pytest.skip("there is no Chromium; on Debian, `apt-get install chromium` brings it")
    with api.sync_playwright() as playwright:
        # Root may not use Chromium's sandbox, and a container often has little shared memory.
        options = ["--no-sandbox", "--disable-dev-shm-usage", "--mute-audio"]
        opened = playwright.chromium.launch(executable_path=CHROMIUM, args=options)
        yield opened
        opened.close()


@pytest.fixture
def tab(browser):
    """A page of a new browser; what it complains of is an error of the test."""
    contexts = []

    def opened(size="desktop", context=None):
        context = context or browser.new_context(**SIZES[size])
        contexts.append(context)
        page = context.new_page()
        page.set_default_timeout(30_000)
        page.complaints = []
        page.on("pageerror", lambda error: page.complaints.append(str(error)))
        page.on("console", lambda one: page.complaints.append(one.text) if one.type == "error" else None)
        page.foreign = []
        page.on("request", lambda one: page.foreign.append(one.url) if "//127.0.0.1:" not in one.url else None)
        return page

    yield opened
    for one in contexts:
        one.close()


def begin(page, address, word="table"):
    page.goto(address)
    page.get_by_role("checkbox").check()
    page.get_by_role("button", name="Begin").click()
    page.get_by_label(word).check()
    page.get_by_role("button", name="Continue").click()
    page.wait_for_selector("#video")


def watch(page):
    """Play the video of the page to its end; the questions are hidden until then."""
    assert not page.locator("#questions").is_visible()
    page.locator("#play").click()
    page.wait_for_selector("#questions:not([hidden])")


def choose(page, number):
    """Choose an answer to every question and send them; waits for the next page."""
    item = page.locator("body").get_attribute("data-item")
    for one in page.locator("fieldset").all():
        one.locator("input").nth(number).check()
    page.locator("#send").click()
    page.wait_for_function("item => document.body.dataset.item !== item", arg=item)


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("kind", [PREFERENCE, RATING])
def test_a_whole_participation(tmp_path, tab, kind, size):
    folder = studies.make(tmp_path / "study", kind, sentences=2)
    study = read_study(folder)
    with serving(folder) as server:
        page = tab(size)
        begin(page, server.address)
        videos = 0
        while page.locator("#video").count():
            # The video and its button are seen without scrolling, nothing is wider than the window.
            assert page.locator("#play").bounding_box()["y"] < SIZES[size]["viewport"]["height"]
            assert page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
            watch(page)
            if size == "phone":  # as large as a finger
                boxes = [one.bounding_box() for one in page.locator("label").all()]
                assert min(box["height"] for box in boxes) >= 40 and min(box["width"] for box in boxes) >= 28
            choose(page, 1)
            videos += 1
        assert "Thank you" in page.content() and page.complaints == [] and page.foreign == []
    (participant,) = read_participants(folder)
    assert participant.finished and videos == len(study.items)
    answers = read_answers(folder)
    assert len(answers) == videos * len(study.questions)
    assert {one.value for one in answers} == ({"none"} if kind == PREFERENCE else {2})


def test_the_keyboard_is_enough(tmp_path, tab):
    folder = studies.make(tmp_path / "study", sentences=1, attention=0)
    with serving(folder) as server:
        page = tab()
        page.goto(server.address)

        def to(selector):
            for _ in range(30):
                if page.evaluate("selector => document.activeElement.matches(selector)", selector):
                    return
                page.keyboard.press("Tab")
            raise AssertionError(f"{selector} is not reached by the keyboard")

        to("input[name=consent]")
        page.keyboard.press("Space")
        page.keyboard.press("Enter")
        page.wait_for_selector("audio")
        to("input[name=word]")
        page.keyboard.press("Space")
        page.keyboard.press("ArrowDown")  # the second word is the right one
        page.keyboard.press("Enter")
        for number in range(2):
            page.wait_for_selector("#video")
            item = page.locator("body").get_attribute("data-item")
            to("#play")
            page.keyboard.press("Space")
            page.wait_for_selector("#questions:not([hidden])")
            # The first answer has the focus by itself.
            assert page.evaluate("document.activeElement.name") == "preference"
            page.keyboard.press("Space")
            if number:
                page.keyboard.press("ArrowRight")
            page.keyboard.press("Enter")
            page.wait_for_function("item => document.body.dataset.item !== item", arg=item)
        page.get_by_text("Thank you").wait_for()
    assert [one.value for one in read_answers(folder)] == ["left", "none"]


def test_a_reload_and_a_lost_connection_lose_nothing(tmp_path, tab):
    folder = studies.make(tmp_path / "study", sentences=1, attention=0)
    with serving(folder) as server:
        page = tab()
        begin(page, server.address)
        watch(page)
        page.get_by_label("Right").check()
        page.reload()
        # The video need not be played again, and the choice is kept.
        page.wait_for_selector("#questions:not([hidden])")
        assert page.get_by_label("Right").is_checked()
        page.context.set_offline(True)
        page.locator("#send").click()
        page.get_by_text("The connection is lost").wait_for()
        assert read_answers(folder) == ()
        page.context.set_offline(False)
        page.get_by_text("Video 1 of 1").first.wait_for()
        assert [one.value for one in read_answers(folder)] == ["right"]
        # The browser was closed: the first page leads back.
        item = page.locator("body").get_attribute("data-item")
        page.goto(server.address)
        page.get_by_role("link", name="Continue it").click()
        page.wait_for_selector("#video")
        assert page.locator("body").get_attribute("data-item") == item
        watch(page)
        choose(page, 0)
        page.goto(server.address)
        assert not page.locator("#resume").is_visible()
    assert len(read_participants(folder)) == 1 and len(read_answers(folder)) == 2


def test_two_tabs_of_one_participant_agree(tmp_path, tab):
    folder = studies.make(tmp_path / "study", sentences=1, attention=0)
    with serving(folder) as server:
        first = tab()
        begin(first, server.address)
        second = tab(context=first.context)
        second.goto(first.url)
        for page in (first, second):
            watch(page)
        choose(first, 0)
        item = first.locator("body").get_attribute("data-item")
        choose(second, 2)
        # The other tab goes on to where the first is.
        assert second.locator("body").get_attribute("data-item") == item
    assert [one.value for one in read_answers(folder)] == ["left"]


def test_skipping_is_noticed_and_a_missing_video_is_said(tmp_path, tab):
    folder = studies.make(tmp_path / "study", sentences=1, attention=0, seconds=2.0)
    with serving(folder) as server:
        page = tab()
        begin(page, server.address)
        page.evaluate("document.getElementById('video').currentTime = 1.8")
        page.locator("#play").click()
        page.get_by_text("A part of the video was skipped").wait_for()
        assert not page.locator("#questions").is_visible()
        watch(page)
        shown = page.locator("#video").get_attribute("src").rpartition("/")[2]
        for path in (folder / "media").iterdir():
            if path.name != shown:
                os.unlink(path)
        choose(page, 0)
        page.get_by_text("The video could not be loaded").wait_for()
        assert not page.locator("#questions").is_visible()


def test_a_full_disk_is_shown_and_the_answer_sent_again(tmp_path, tab):
    folder = studies.make(tmp_path / "study", sentences=1, attention=0)
    with serving(folder) as server:
        page = tab()
        begin(page, server.address)
        watch(page)
        page.get_by_label("Left").check()
        server.store._database.execute("PRAGMA query_only = 1")  # writing fails
        page.locator("#send").click()
        page.get_by_text("could not be stored").wait_for()
        assert read_answers(folder) == ()
        server.store._database.execute("PRAGMA query_only = 0")
        page.get_by_text("Video 1 of 1").first.wait_for()
    assert len(read_answers(folder)) == 1
