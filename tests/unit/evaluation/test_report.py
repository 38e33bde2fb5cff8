"""The report: one page, nothing from outside, nothing of a stranger's text taken for markup."""

import base64
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
from visualspeech.evaluation.overview import Band, Line, Shown
from visualspeech.evaluation.report import (
    FEW_UTTERANCES,
    MAX_FINDINGS,
    MAX_UTTERANCES,
    FileLink,
    Picture,
    ReportContent,
    ShownTable,
    StudySection,
    SystemSection,
    UtteranceFiles,
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
        if tag not in ("meta", "img", "wbr", "br"):
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag, tag

    def handle_data(self, data):
        self.text.append(data)


def system(text: str = "plain", name: str = "fan2015", **changes) -> SystemSection:
    picture = Picture(plots.mode_pictures(np.zeros((1, 1, 4, 4, 3), np.uint8)), text)
    files = (FileLink("TSV", f"{name}/tables/{text} #1.tsv"), FileLink("TeX", f"{name}/tables/{text} #1.tex"))
    whole = SystemSection(
        name=name,
        title=f"{name} {text}",
        conclusion=f"{text} is the best of 3 models.",
        facts=(("rate", "25 Hz"), ("drift removal", text)),
        tables=(ShownTable(to_html(made()[1]), files),),
        comparisons=(ShownTable('<figure class="result-table">compared</figure>', files[:1]),),
        learning_curves=(picture,),
        trajectories=(picture,),
        modes=(picture,),
        videos=(
            Video(f"{name}/videos/{text} #1?.mp4", text, text, text, text, b"still"),
            Video(f"{name}/videos/{text} #2.mp4", text, text, text, text),
        ),
    )
    return replace(whole, **changes)


def band(text: str = "plain") -> Band:
    lines = (
        Line(f"FBB {text}", "best", (Shown(1.0, 0.8, 1.2),), text),
        Line("2 further models", "others", (Shown(1.5, 1.2, 1.8), Shown(1.6, 1.2, 1.8))),
        Line("training mean", "baseline", (Shown(2.0, 1.9, 2.1),)),
        Line("floor", "floor", (Shown(0.5, float("nan"), float("nan")),)),
    )
    return Band(text, lines, 2.0, 0.5)


def content(text: str = "plain", **changes) -> ReportContent:
    whole = ReportContent(
        corpus=text,
        split_hash="0123456789ab",
        systems=(system(text), system(text, "second")),
        strip=(
            Video(f"fan2015/videos/{text}.mp4", text, text, text, text, b"still", b"film"),
            Video(f"fan2015/videos/{text} large.mp4", text, text, text, text, b"still"),
        ),
        bands=(band(text),),
        short='<figure class="result-table">short</figure>',
        tables=(ShownTable('<figure class="result-table">across</figure>'),),
        test=(UtteranceFiles(text, text, (FileLink("TextGrid", f"alignment/textgrid/{text}.TextGrid"),)),),
        folders=(FileLink("textgrid", "alignment/textgrid/"),),
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
    ids = [attributes["id"] for _, attributes in page.tags if "id" in attributes]
    assert ids == ["overview", "across", "system-1", "system-2", "recordings", "timings", "settings", "licences"]
    assert page.open == []
    text = " ".join(" ".join(page.text).split())
    for part in ("0123456789ab", "25 Hz", "RMSE(appearance)", "Visual codings", "100", "1 500", "non-commercial", "48"):
        assert part in text


def test_what_was_found_comes_first_and_unfolded():
    text = render_report(content())
    first, _, rest = text.partition("<details")
    order = ["plain is the best of 3 models", "<video", "Fewer than 20 test utterances", 'class="overview"', ">short<"]
    assert [first.count(part) > 0 for part in order] == [True] * 5
    places = [first.index(part) for part in order]
    assert places == sorted(places)
    for part in (">across<", "RMSE(appearance)", "compared", "learning", "Visual codings", "PocketSphinx"):
        assert part not in first
    assert rest.count("<details") > 10 and not re.search("<details[^>]* open", text)
    # Folded parts are printed.
    assert "details::details-content" in text


def test_without_a_common_measure_the_main_tables_stand_above_the_folds():
    first, _, _ = render_report(content(bands=(), short="")).partition("<details")
    assert "RMSE(appearance)" in first and 'class="overview"' not in first


@pytest.mark.parametrize(("count", "warned"), [(FEW_UTTERANCES - 1, True), (FEW_UTTERANCES, False)])
def test_few_test_utterances_are_a_warning_above_the_tables(count, warned):
    text = render_report(content(utterances={"train": 100, "validation": 10, "test": count}))
    assert ("Fewer than 20 test utterances" in text) == warned
    if warned:
        assert text.index("Fewer than") < text.index('<figure class="result-table"')


def test_small_videos_are_embedded_and_large_ones_read_when_played():
    page = Page(render_report(content()))
    videos = [attributes for tag, attributes in page.tags if tag == "video"]
    assert len(videos) == 2 + 2  # one of each system has no still and is a link
    assert videos[0]["src"] == "data:video/mp4;base64," + base64.b64encode(b"film").decode()
    assert videos[1]["src"] == "fan2015/videos/plain%20large.mp4"
    for one in videos:
        assert one["preload"] == "none" and one["poster"].startswith("data:image/jpeg;base64,") and "controls" in one
    policy = next(attributes["content"] for _, attributes in page.tags if "content-security" in str(attributes).lower())
    assert "media-src 'self' data:" in policy and "default-src 'none'" in policy and "script" not in policy


def test_the_figure_marks_baseline_and_floor_and_has_intervals():
    page = Page(render_report(content()))
    circles = [attributes["cx"] for tag, attributes in page.tags if tag == "circle"]
    assert circles == ["40.00%", "60.00%", "64.00%", "80.00%", "20.00%"]  # of an axis that ends at 2.5
    lines = [attributes for tag, attributes in page.tags if tag == "line"]
    assert [one["x1"] for one in lines if one["class"] == "baseline"] == ["80.00%"] * 4
    assert [one["x1"] for one in lines if one["class"] == "floor"] == ["20.00%"] * 4
    assert [(one["x1"], one["x2"]) for one in lines if one["class"] == "interval"][0] == ("32.00%", "48.00%")
    assert len([one for one in lines if one["class"] == "interval"]) == 2  # the floor's is not known
    labels = [attributes["aria-label"] for tag, attributes in page.tags if tag == "svg" and "aria-label" in attributes]
    assert labels[0] == "FBB plain: 1.00 % [0.80, 1.20]" and labels[1].startswith("2 further models: 1.50–1.60 %")


def test_tables_have_links_to_their_files():
    page = Page(render_report(content()))
    links = [attributes["href"] for tag, attributes in page.tags if tag == "a"]
    for one in ("fan2015/tables/plain%20%231.tsv", "fan2015/tables/plain%20%231.tex", "alignment/textgrid/",
                "alignment/textgrid/plain.TextGrid"):  # fmt: skip
        assert one in links


def test_systems_stand_side_by_side():
    text = render_report(content())
    sections = text.split('<details class="section" id="system-')
    for name, section in (("fan2015", sections[1]), ("second", sections[2])):
        assert f"<summary>{name} plain</summary>" in section and f"{name}/videos/plain" in section
        for part in (
            "Tables",
            "Paired comparisons",
            "Videos",
            "Predicted and recorded trajectories",
            "Learning curves",
            "Modes of appearance",
        ):
            assert f"<summary>{part}" in section
    bare = render_report(content(systems=(SystemSection("bare", "Bare"),), tables=()))
    assert "<summary>Videos" not in bare and "No result table was made" in bare and 'id="across"' not in bare


def test_settings_have_a_fold_for_each_part():
    settings = {
        "seed": 1,
        "corpora": {"demo": {"shards": 4}},
        "systems": {"fan2015": {"rate": 25, "rows": [{"name": "FBB-64", "nodes": 64}]}},
    }
    text = render_report(content(settings=settings))
    for heading in ("Run", "Corpus demo", "System fan2015", "Models of fan2015, with all their settings"):
        assert f"<summary>{heading}</summary>" in text
    system = text.split("<summary>System fan2015</summary>")[1].split("</pre>")[0]
    assert "rate: 25" in system and "FBB-64" not in system and "nodes: 64" in text


def test_many_test_utterances_are_cut_and_counted():
    test = tuple(UtteranceFiles(f"u{i}", "", ()) for i in range(MAX_UTTERANCES + 3))
    assert "3 further utterances" in render_report(content(test=test))


def test_viewing_tests_have_a_section_of_their_own():
    picture = Picture(plots.mode_pictures(np.zeros((1, 1, 4, 4, 3), np.uint8)), "<b>")
    table = ShownTable("<p>table</p>", (FileLink("TSV", "evaluations/x/ratings.tsv"),))
    study = StudySection("Viewing test <b>", "evaluations/<b>/evaluation.html", (table,), (picture,))
    text = render_report(content(studies=(study,)))
    section = text[text.index('id="study-1"') :].split("</details>")[0]
    assert "Viewing test &lt;b&gt;" in section and "<p>table</p>" in section and 'alt="&lt;b&gt;"' in section
    assert 'href="evaluations/%3Cb%3E/evaluation.html"' in section and "evaluations/x/ratings.tsv" in section
    assert 'id="study-1"' not in render_report(content())
    assert Page(text).open == []


def test_commit_date_and_command_are_named_where_known():
    text = render_report(content(commit="abc1234", date="2024-05-01", command="snakemake all"))
    for name, value in (("commit", "abc1234"), ("date", "2024-05-01"), ("command", "snakemake all")):
        assert f'<dt>{name}</dt><dd class="wrap">{value}</dd>' in text
    assert "<dt>commit</dt>" not in render_report(content(commit=""))


def test_nothing_comes_from_outside():
    page = Page(render_report(content()))
    for tag, attributes in page.tags:
        assert tag not in ("script", "link", "iframe", "object", "embed")
        for name, value in attributes.items():
            if name == "poster" or (name == "src" and tag == "img"):
                assert value.startswith("data:image/")
            elif name in ("href", "src") and not value.startswith("data:video/mp4;base64,"):
                assert not urlsplit(value).scheme and not urlsplit(value).netloc
    text = render_report(content())
    for part in ("http://", "https://", "url(", "@import", "<base", "srcset", "data:text", "data:application"):
        assert part not in text


def test_text_of_strangers_stays_text():
    plain, evil = Page(render_report(content())), Page(render_report(content(EVIL)))
    assert [tag for tag, _ in evil.tags] == [tag for tag, _ in plain.tags]
    assert [sorted(attributes) for _, attributes in evil.tags] == [sorted(attributes) for _, attributes in plain.tags]
    assert not any("onclick" in attributes or "onerror" in attributes for _, attributes in evil.tags)
    assert EVIL in "".join(evil.text)


@pytest.mark.parametrize("path", ["javascript:alert(1)", "//host/x.mp4", "http://host/x.mp4"])
def test_a_path_is_a_file_and_no_address(path):
    videos = (Video(path, "a"), Video(path, "a", still=b"still"))
    table = ShownTable("<figure></figure>", (FileLink("TSV", path),))
    page = Page(render_report(content(systems=(system(videos=videos, tables=(table,)),), strip=videos[1:])))
    links = [attributes[name] for _, attributes in page.tags for name in ("href", "src") if name in attributes]
    for link in links:
        assert link.startswith("data:") or not (urlsplit(link).scheme or urlsplit(link).netloc)


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
