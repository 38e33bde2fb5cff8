"""The report of a run: one HTML page that makes no network requests."""

import base64
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import quote

from visualspeech.corpora.findings import REJECT, Finding
from visualspeech.corpora.split import SPLITS
from visualspeech.evaluation.overview import Band
from visualspeech.evaluation.overview_figure import OverviewFigure, overview_figure
from visualspeech.evaluation.timings import StageTiming, by_stage

TEMPLATES = Path(__file__).parent / "templates"

#: Maximum number of findings and of utterances shown, so that the page of a large corpus still opens in a browser.
MAX_FINDINGS = 500
MAX_UTTERANCES = 200
#: Number of test utterances below which the page warns that figures are rough.
FEW_UTTERANCES = 20
#: Sections of the settings that hold one entry per corpus, visual coding or system.
NAMED = {"corpora": "Corpus", "codings": "Visual coding", "systems": "System"}

#: What the results of a run depend on besides the user's recordings: (what, source, terms).
LICENCES = (
    (
        "68-point landmark model",
        "face-recognition-models",
        "The file is free to use (CC0), but the images it was trained on (iBUG 300-W) are for non-commercial use only. "
        "Replace the tracker for any other use.",
    ),
    ("Face detector and landmark code", "dlib", "Boost Software License 1.0."),
    ("English acoustic model and dictionary", "PocketSphinx (Carnegie Mellon University)", "BSD licences."),
    (
        "Letter-to-sound rules, voice of the demo corpus",
        "eSpeak NG, through espeakng-loader",
        "GNU GPL 3 or later, for the library itself.",
    ),
    ("Video decoders and encoders", "FFmpeg and x264, in the wheel of PyAV", "GNU GPL 2 or later (PyAV itself: BSD)."),
    (
        "Face of the demo corpus",
        "astronaut.png of scikit-image (NASA), changed until it shows no real person",
        "Public domain.",
    ),
    ("This program", "visualspeech", "MIT."),
)


@dataclass(frozen=True)
class Picture:
    """A picture in the report.

    Parameters
    ----------
    png : bytes of a PNG (from :mod:`visualspeech.evaluation.plots`)
    caption : what the picture shows, also used as its alternative text
    """

    png: bytes
    caption: str


@dataclass(frozen=True)
class FileLink:
    """A link to a file: its label, and its path relative to the report, with forward slashes."""

    label: str
    path: str


@dataclass(frozen=True)
class ShownTable:
    """A table in the report: HTML of :func:`visualspeech.evaluation.forms.to_html`, and its files in other forms."""

    html: str
    files: tuple[FileLink, ...] = ()


@dataclass(frozen=True)
class Video:
    """A video in the report.

    Parameters
    ----------
    path : relative to the report, with forward slashes
    utterance, transcript : what is said in it
    model, system : whose prediction it shows
    still : bytes of a JPEG, shown until the video plays; empty: the video is a link
    content : bytes of the MP4, to embed it in the page; empty: the page reads the file
    """

    path: str
    utterance: str
    transcript: str = ""
    model: str = ""
    system: str = ""
    still: bytes = b""
    content: bytes = b""


@dataclass(frozen=True)
class UtteranceFiles:
    """A test utterance with links to its files."""

    id: str
    transcript: str
    files: tuple[FileLink, ...] = ()


@dataclass(frozen=True)
class SystemSection:
    """What the report shows of one system; empty fields are left out.

    Parameters
    ----------
    name : of the system, unique in the report
    title : for people
    conclusion : a sentence on its best model (:mod:`visualspeech.evaluation.conclusions`)
    facts : (name, text) pairs: frame rate, visual coding, ...
    tables : result tables; the first is the main one
    comparisons : all paired comparisons as one table
    learning_curves, trajectories, modes, visemes, figures : pictures
    videos : of test utterances
    """

    name: str
    title: str
    conclusion: str = ""
    facts: tuple[tuple[str, str], ...] = ()
    tables: tuple[ShownTable, ...] = ()
    comparisons: tuple[ShownTable, ...] = ()
    learning_curves: tuple[Picture, ...] = ()
    trajectories: tuple[Picture, ...] = ()
    modes: tuple[Picture, ...] = ()
    figures: tuple[Picture, ...] = ()
    visemes: tuple[Picture, ...] = ()
    videos: tuple[Video, ...] = ()


@dataclass(frozen=True)
class StudySection:
    """What the report shows of an evaluated viewing test.

    Parameters
    ----------
    title : which says so where the answers are simulated
    page : path of the page of its evaluation, relative to the report
    tables : the main one first
    figures : pictures
    """

    title: str
    page: str
    tables: tuple[ShownTable, ...]
    figures: tuple[Picture, ...]


@dataclass(frozen=True)
class ReportContent:
    """The content of the report of a corpus; sections of empty fields are left out or say that they are empty.

    Parameters
    ----------
    corpus : name
    split_hash : from :func:`visualspeech.provenance.split_hash`
    systems : one section per system
    strip : videos at the top
    bands : the figure of all systems
    short : the short table as HTML; empty for none
    tables : comparisons across systems
    studies : one section per evaluated viewing test
    consent : whose face the corpus shows and by what permission, from its settings; if empty, the report warns
    utterances : name of a split -> number of accepted utterances
    test : test utterances with their files
    folders : links to folders of recordings and alignments
    findings : rejections and warnings of all stages
    timings : cost of the rules
    settings : all settings of the run (plain data)
    versions : name of a program or library -> version
    commit, date, command : of the run that made the report; empty if not known
    licences : (what, source, terms)
    """

    corpus: str
    split_hash: str
    systems: tuple[SystemSection, ...] = ()
    strip: tuple[Video, ...] = ()
    bands: tuple[Band, ...] = ()
    short: str = ""
    tables: tuple[ShownTable, ...] = ()
    studies: tuple[StudySection, ...] = ()
    consent: str = ""
    utterances: Mapping[str, int] = field(default_factory=dict)
    test: tuple[UtteranceFiles, ...] = ()
    folders: tuple[FileLink, ...] = ()
    findings: tuple[Finding, ...] = ()
    timings: tuple[StageTiming, ...] = ()
    settings: Mapping = field(default_factory=dict)
    versions: Mapping[str, str] = field(default_factory=dict)
    commit: str = ""
    date: str = ""
    command: str = ""
    licences: tuple[tuple[str, str, str], ...] = LICENCES

    @property
    def figure(self) -> OverviewFigure:
        """The figure of all systems as it is drawn."""
        return overview_figure(self.bands)


def render_report(content: ReportContent) -> str:
    """The report as the text of an HTML page.

    Pictures and small videos are embedded in the page; larger videos are files beside it. All text is escaped, because
    transcripts, file names and settings may come from untrusted sources, and a content-security policy forbids scripts
    and outside addresses. The same content gives the same text.
    """
    from jinja2 import Environment, FileSystemLoader, StrictUndefined
    from markupsafe import Markup

    environment = Environment(
        loader=FileSystemLoader(TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    # Tables are HTML already, with all text in them escaped.
    environment.filters |= {
        "data_address": _data_address, "link": _link, "figure": _figure, "count": _count, "html": Markup,
    }  # fmt: skip
    rejected = [one for one in content.findings if one.level == REJECT]
    warnings = [one for one in content.findings if one.level != REJECT]
    timings = by_stage(content.timings)
    return environment.get_template("report.html").render(
        content=content,
        rejected=rejected,
        rejected_utterances=len({one.id for one in rejected}),
        warnings=warnings,
        most=MAX_FINDINGS,
        most_utterances=MAX_UTTERANCES,
        few=content.utterances.get("test", FEW_UTTERANCES) < FEW_UTTERANCES,
        few_utterances=FEW_UTTERANCES,
        settings=_settings_texts(content.settings),
        timings=timings,
        total=sum(timing.seconds for timing in timings),
        splits=[name for name in SPLITS if name in content.utterances],
        made=[
            (name, text)
            for name, text in (
                ("version", content.versions.get("visualspeech", "")),
                ("commit", content.commit),
                ("date", content.date),
                ("command", content.command),
            )
            if text
        ],
    )


def _data_address(content: bytes, kind: str = "image/png") -> str:
    return f"data:{kind};base64," + base64.b64encode(content).decode("ascii")


def _link(path: str) -> str:
    """A relative path as a URL, escaped so that no part of it is read as a scheme or a host."""
    return quote(path.lstrip("/"))


def _figure(value: float, digits: int = 0) -> str:
    """A number with thin spaces between groups of three digits; a dash for NaN."""
    return "–" if value != value else f"{value:,.{digits}f}".replace(",", "\u202f")


def _count(number: int, unit: str, plural: str = "") -> str:
    return f"{_figure(number)} {unit if number == 1 else plural or unit + 's'}"


def _settings_texts(settings: Mapping) -> list[tuple[str, str]]:
    """(heading, YAML) of the settings of the run, and of each corpus, visual coding and system.

    The rows of a system are its models with all their settings; they have a text of their own.
    """
    named = {key: settings[key] for key in NAMED if isinstance(settings.get(key), Mapping)}
    texts = [("Run", {key: value for key, value in settings.items() if key not in named})]
    for key, entries in named.items():
        for name, entry in entries.items():
            rows = entry.get("rows") if isinstance(entry, Mapping) else None
            own = {inner: value for inner, value in entry.items() if inner != "rows"} if rows else entry
            texts.append((f"{NAMED[key]} {name}", own))
            texts += [(f"Models of {name}, with all their settings", {"rows": rows})] if rows else []
    return [(heading, _yaml(value)) for heading, value in texts if value]


def _yaml(settings) -> str:
    import yaml

    return yaml.safe_dump(_plain(settings), sort_keys=True, allow_unicode=True, default_flow_style=None, width=100)


def _plain(value):
    """Data of types that YAML can write: mappings, lists and scalars; values of other types as text."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [_plain(item) for item in value]
    return value if value is None or isinstance(value, bool | int | float | str) else str(value)
