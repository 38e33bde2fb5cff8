"""One self-contained HTML page about a run: it opens in a browser offline and asks nothing of any other machine."""

import base64
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import quote

from visualspeech.corpora.findings import REJECT, Finding
from visualspeech.evaluation.timings import StageTiming

TEMPLATES = Path(__file__).parent / "templates"

#: Findings shown one by one; a corpus of thousands of odd recordings must not make a page that no browser opens.
MOST_FINDINGS = 500

#: What the results of a run rest on besides the user's recordings: (what, where from, terms).
LICENCES = (
    (
        "68-point landmark model",
        "face-recognition-models",
        "The file is given away freely (CC0), but the pictures it was trained on (iBUG 300-W) are for non-commercial "
        "use. Replace the tracker for any other use.",
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
    caption : what it shows, for those who cannot see it too
    """

    png: bytes
    caption: str


@dataclass(frozen=True)
class Video:
    """A video that the report links to.

    Parameters
    ----------
    path : relative to the report, with forward slashes
    utterance, transcript : what is said in it
    model : whose prediction it shows
    """

    path: str
    utterance: str
    transcript: str = ""
    model: str = ""


@dataclass(frozen=True)
class SystemSection:
    """What the report shows of one system; an empty field leaves its part out.

    Parameters
    ----------
    name : of the system, unique in the report
    title : for people
    facts : (name, text) pairs: frame rate, visual coding, ...
    tables : result tables as HTML, from :func:`visualspeech.evaluation.forms.to_html`; the first is the main one
    learning_curves, trajectories, modes : pictures
    videos : links
    """

    name: str
    title: str
    facts: tuple[tuple[str, str], ...] = ()
    tables: tuple[str, ...] = ()
    learning_curves: tuple[Picture, ...] = ()
    trajectories: tuple[Picture, ...] = ()
    modes: tuple[Picture, ...] = ()
    videos: tuple[Video, ...] = ()


@dataclass(frozen=True)
class ReportContent:
    """Everything that the report of a corpus shows; an empty field leaves its section out or says that it is empty.

    Parameters
    ----------
    corpus : name
    split_hash : from :func:`visualspeech.provenance.split_hash`
    systems : a section each
    tables : tables across systems as HTML
    consent : whose face the corpus holds and by what permission, as its file says; empty makes the report warn
    utterances : name of a split -> number of accepted utterances
    findings : rejections and warnings of all stages
    timings : cost of the stages
    settings : all settings of the run (plain data)
    versions : name of a program or library -> version
    commit, date, command : of the run that made the report; empty where they are not known
    licences : (what, where from, terms)
    """

    corpus: str
    split_hash: str
    systems: tuple[SystemSection, ...] = ()
    tables: tuple[str, ...] = ()
    consent: str = ""
    utterances: Mapping[str, int] = field(default_factory=dict)
    findings: tuple[Finding, ...] = ()
    timings: tuple[StageTiming, ...] = ()
    settings: Mapping = field(default_factory=dict)
    versions: Mapping[str, str] = field(default_factory=dict)
    commit: str = ""
    date: str = ""
    command: str = ""
    licences: tuple[tuple[str, str, str], ...] = LICENCES


def render_report(content: ReportContent) -> str:
    """The report as the text of an HTML page.

    Pictures are part of the page; the videos alone are links to files beside it. All text is escaped (transcripts,
    file names and settings may come from strangers), and the page forbids itself scripts and any outside address.
    The same content gives the same text.
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
    return environment.get_template("report.html").render(
        content=content,
        rejected=rejected,
        rejected_utterances=len({one.id for one in rejected}),
        warnings=warnings,
        most=MOST_FINDINGS,
        settings=_settings_text(content.settings),
        total=sum(timing.seconds for timing in content.timings),
        splits=[name for name in ("train", "validation", "test") if name in content.utterances],
        made=[
            (name, text)
            for name, text in (("commit", content.commit), ("date", content.date), ("command", content.command))
            if text
        ],
    )


def _data_address(png: bytes) -> str:
    return "data:image/png;base64," + base64.b64encode(png).decode("ascii")


def _link(path: str) -> str:
    """A relative path as an address: a colon would make a scheme of what stands before it, two slashes a host."""
    return quote(path.lstrip("/"))


def _figure(value: float, digits: int = 0) -> str:
    """A number with thin groups of three, or a dash where there is none."""
    return "–" if value != value else f"{value:,.{digits}f}".replace(",", "\u202f")


def _count(number: int, unit: str, plural: str = "") -> str:
    return f"{_figure(number)} {unit if number == 1 else plural or unit + 's'}"


def _settings_text(settings: Mapping) -> str:
    import yaml

    return yaml.safe_dump(_plain(settings), sort_keys=True, allow_unicode=True, default_flow_style=None, width=100)


def _plain(value):
    """Mappings and sequences of other kinds as those that YAML can write; anything else as its text."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [_plain(item) for item in value]
    return value if value is None or isinstance(value, bool | int | float | str) else str(value)
