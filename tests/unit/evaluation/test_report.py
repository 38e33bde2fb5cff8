"""The report: one page, nothing from outside, nothing of a stranger's text taken for markup."""

import html.parser
import re
from dataclasses import replace
from urllib.parse import urlsplit

import numpy as np
import pytest

from tests.unit.evaluation.test_tables import made
from visualspeech.corpora.findings import Finding
from visualspeech.evaluation import plots
from visualspeech.evaluation.forms import to_html
from visualspeech.evaluation.report import (
    MAX_FINDINGS,
    Picture,
    ReportContent,
    StudySection,
    SystemSection,
    Video,
    render_report,
)
from visualspeech.evaluation.timings import StageTiming

EVIL = "<script>alert('1')</script><img src=x onerror=alert(2)>\" onclick=\"alert(3)"


class Page(html.parser.HTMLParser):
    """Tags with their attributes, text, and whether all that was opened was closed."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags, self.text, self.open = [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))
        if tag not in ("meta", "img", "wbr"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag, tag

    def handle_data(self, data):
        self.text.append(data)


def system(text: str = "plain", name: str = "fan2015", **changes) -> SystemSection:
    picture = Picture(plots.mode_pictures(np.zeros((1, 1, 4, 4, 3), np.uint8)), text)
    whole = SystemSection(
        name=name,
        title=f"{name} {text}",
        facts=(("rate", "25 Hz"), ("drift removal", text)),
        tables=(to_html(made()[1]),),
        learning_curves=(picture,),
        trajectories=(picture,),
        modes=(picture,),
        videos=(Video(f"{name}/videos/{text} #1?.mp4", text, text, text),),
    )
    return replace(whole, **changes)


def content(text: str = "plain", **changes) -> ReportContent:
    whole = ReportContent(
        corpus=text,
        split_hash="0123456789ab",
        systems=(system(text), system(text, "second")),
        tables=('<figure class="result-table">across</figure>',),
        consent=text,
        utterances={"train": 48, "validation": 6, "test": 6},
        findings=(
            Finding(text, "check", "reject", text, text, text),
            Finding("b", "check", "warn", text, text),
        ),
        timings=(
            StageTiming("fit_aam", 1, 100.0, 100.0, 1500.0, 20000),
            StageTiming("short", 1, 0.0, 0.0, float("nan")),
        ),
        settings={"corpus": {"name": text}, text: [1, (2, 3)], "none": None},
        versions={"torch": text},
        commit=text,
        date=text,
        command=text,
    )
    return replace(whole, **changes)


def test_every_section_is_there():
    page = Page(render_report(content()))
    ids = [attributes["id"] for tag, attributes in page.tags if tag == "section"]
    assert ids == ["across", "system-1", "system-2", "recordings", "timings", "settings", "licences"]
    assert page.open == []
    linked = [attributes["href"][1:] for tag, attributes in page.tags if tag == "a" and attributes["href"][0] == "#"]
    assert linked == ids
    text = " ".join(" ".join(page.text).split())
    for part in ("0123456789ab", "25 Hz", "RMSE(appearance)", "fit_aam", "200", "1 500", "non-commercial", "48"):
        assert part in text


def test_systems_stand_side_by_side():
    text = render_report(content())
    sections = text.split("<section ")
    for name, section in (("fan2015", sections[2]), ("second", sections[3])):
        assert f"<h2>{name} plain</h2>" in section and f"{name}/videos/plain" in section
        for part in (
            "Results",
            "Videos",
            "Predicted and recorded trajectories",
            "Learning curves",
            "Modes of appearance",
        ):
            assert f"<h3>{part}</h3>" in section
    bare = render_report(content(systems=(SystemSection("bare", "Bare"),), tables=()))
    assert "<h3>Videos</h3>" not in bare and "No result table was made" in bare and 'id="across"' not in bare


def test_viewing_tests_have_a_section_of_their_own():
    picture = Picture(plots.mode_pictures(np.zeros((1, 1, 4, 4, 3), np.uint8)), "<b>")
    study = StudySection("Viewing test <b>", "evaluations/<b>/evaluation.html", ("<p>table</p>",), (picture,))
    text = render_report(content(studies=(study,)))
    section = text[text.index('<section id="studies">') :].split("</section>")[0]
    assert "Viewing test &lt;b&gt;" in section and "<p>table</p>" in section and 'alt="&lt;b&gt;"' in section
    assert 'href="evaluations/%3Cb%3E/evaluation.html"' in section and 'href="#studies"' in text
    assert "studies" not in render_report(content()).split("</style>")[1]
    assert Page(text).open == []


def test_commit_date_and_command_are_named_where_known():
    text = render_report(content(commit="abc1234", date="2024-05-01", command="snakemake all"))
    assert "commit: abc1234" in text and "date: 2024-05-01" in text and "command: snakemake all" in text
    assert "commit:" not in render_report(content(commit=""))


def test_nothing_comes_from_outside():
    page = Page(render_report(content()))
    for tag, attributes in page.tags:
        assert tag not in ("script", "link", "iframe", "object", "embed")
        for name, value in attributes.items():
            if name == "src":
                assert value.startswith("data:image/png;base64,")
            if name == "href":
                assert not urlsplit(value).scheme and not urlsplit(value).netloc
    text = render_report(content())
    assert "http://" not in text and "https://" not in text and "url(" not in text and "@import" not in text


def test_text_of_strangers_stays_text():
    plain, evil = Page(render_report(content())), Page(render_report(content(EVIL)))
    assert [tag for tag, _ in evil.tags] == [tag for tag, _ in plain.tags]
    assert [sorted(attributes) for _, attributes in evil.tags] == [sorted(attributes) for _, attributes in plain.tags]
    assert not any("onclick" in attributes or "onerror" in attributes for _, attributes in evil.tags)
    assert EVIL in "".join(evil.text)


@pytest.mark.parametrize("path", ["javascript:alert(1)", "//host/x.mp4", "http://host/x.mp4"])
def test_a_path_is_a_file_and_no_address(path):
    page = Page(render_report(content(systems=(system(videos=(Video(path, "a"),)),))))
    link = next(attributes["href"] for tag, attributes in page.tags if attributes.get("href", "#")[0] != "#")
    assert not urlsplit(link).scheme and not urlsplit(link).netloc


def test_links_to_files_with_odd_names():
    page = Page(render_report(content(systems=(system(videos=(Video("fan2015/videos/a b#1?.mp4", "a"),)),))))
    assert any(attributes.get("href") == "fan2015/videos/a%20b%231%3F.mp4" for _, attributes in page.tags)


def test_missing_consent_warns():
    assert "No consent is stated" in render_report(content(consent=""))
    assert "No consent is stated" not in render_report(content())


def test_empty_content_makes_a_page():
    text = render_report(ReportContent("demo", "ab"))
    assert Page(text).open == [] and "No system was run" in text and "every recording could be used" in text


def test_thousands_of_findings_are_cut_and_counted():
    findings = tuple(Finding(f"u{i}", "check", "warn", "f", "clipped") for i in range(MAX_FINDINGS + 7))
    text = render_report(content(findings=findings))
    assert text.count('<td class="wrap">clipped</td>') == MAX_FINDINGS
    assert "7 more findings" in text


def test_rejected_utterances_are_counted_once():
    findings = tuple(Finding("one", stage, "reject", "f", "bad") for stage in ("check", "alignment"))
    assert re.search(
        r"1 utterance</span> could not be used; everything here was made without it",
        render_report(content(findings=findings)),
    )


def test_same_content_same_text():
    assert render_report(content()) == render_report(content())


def test_evaluation_does_not_load_torch():
    import subprocess
    import sys

    code = (
        "import sys; from visualspeech.evaluation import across_systems, gains, gathering, plots, report;"
        "from visualspeech.evaluation import tables, topologies;"
        "sys.exit('torch' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
