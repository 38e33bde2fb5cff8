"""The report of a finished run, and Snakemake's own report of it."""

import re
from html.parser import HTMLParser

import pytest

from tests.workflow.running import snakemake

pytestmark = pytest.mark.xdist_group("workflow")


class Addresses(HTMLParser):
    """All addresses of a page by tag, without those that hold the data themselves."""

    def __init__(self, text):
        super().__init__()
        self.found = []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        values = (value for name, value in attributes if name in ("href", "src"))
        self.found += [(tag, value) for value in values if not value.startswith("data:")]


def test_the_report_shows_what_was_found_and_links_to_files_that_exist(tiny_run):
    folder = tiny_run / "results" / "tiny"
    text = (folder / "report.html").read_text()
    first = text.split("<details")[0]
    assert "on the validation utterances" in first and "test utterances its lips are on average" in first
    assert "<video" in first and 'class="overview"' in first and "Fewer than 20 test utterances" in first
    assert text.count("<td>") > 0 and "Fan et al. 2015" in first
    addresses = Addresses(text).found
    names = [address for _, address in addresses]
    assert "fan2015/tables/objective.tsv" in names and "fan2015/tables/objective.tex" in names
    assert any(name.endswith(".TextGrid") for name in names) and "alignment/textgrid/" in names
    for name in names:
        assert (folder / name).exists(), name
    # All defaults are filled in.
    run = text.split("<summary>Run</summary>")[1].split("</pre>")[0]
    assert "speech_threshold: " in run and not re.search(r": \{\}$", run, re.MULTILINE)


def test_snakemake_reports_tables_and_videos(tiny_run, tmp_path):
    page = tmp_path / "report.html"
    done = snakemake(tiny_run, "--report", str(page), "all")
    assert done.returncode == 0, done.stdout[-3000:]
    text = page.read_text()
    for part in ("tables/objective.html", "tables/systems.html", "Videos", ".mp4", "results/tiny/report.html"):
        assert part in text
    assert "labels" in text and "fan2015" in text
