"""Figures that papers print, to stand beside those of a run; each with its source, in ``published/*.yaml``."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

from visualspeech.errors import SettingError
from visualspeech.evaluation.metrics import Metric, metric_named
from visualspeech.settings import read_yaml

FOLDER = Path(__file__).parent / "published"


@dataclass(frozen=True)
class PublishedSelection:
    """One printed table of means and standard deviations over utterances.

    Parameters
    ----------
    metrics : names of the measures, in the order of its columns
    figures : row -> measure -> (mean, standard deviation)
    digits : decimals that the paper prints, by measure
    notes : sentences below the table
    """

    metrics: tuple[str, ...]
    figures: Mapping[str, Mapping[str, tuple[float, float]]]
    digits: Mapping[str, int]
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class PublishedRegions:
    """A printed table of models by region of the face.

    Parameters
    ----------
    metrics : names of the measures, in the order of its columns
    digits : decimals that the paper prints, by measure
    rows : of each row its title, nodes per layer, number of parameters as printed, and figures by measure
    """

    metrics: tuple[str, ...]
    digits: Mapping[str, int]
    rows: tuple[tuple[str, int, str, Mapping[str, float]], ...]


@dataclass(frozen=True)
class Published:
    """What a paper prints; an empty field is a table that it does not have.

    Parameters
    ----------
    source, corpus : for people
    metrics : names of the measures, in the order of its columns
    topologies : (stack, nodes) -> figures by measure
    stacks, nodes : what the paper trained, which may be more than it prints
    gains : name of a model -> figures by measure: reference models, and the best network
    best : name of the best network among them
    preference : answer -> share of the listeners' answers
    majority : answer -> share of the sentences by majority of the viewers
    ratings : what is said of ratings of viewers -> the text as printed
    selections : name of a table of chosen rows -> what the paper prints in it
    regions : its table of models by region of the face
    emotions : emotion -> number of its test utterances
    """

    source: str
    corpus: str
    metrics: tuple[str, ...] = ()
    topologies: Mapping[tuple[str, int], Mapping[str, float]] = field(default_factory=dict)
    stacks: tuple[str, ...] = ()
    nodes: tuple[int, ...] = ()
    gains: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    best: str = ""
    preference: Mapping[str, float] = field(default_factory=dict)
    majority: Mapping[str, float] = field(default_factory=dict)
    ratings: Mapping[str, str] = field(default_factory=dict)
    selections: Mapping[str, PublishedSelection] = field(default_factory=dict)
    regions: PublishedRegions | None = None
    emotions: Mapping[str, int] = field(default_factory=dict)


def published_names() -> list[str]:
    """Keys of all files of published figures."""
    return sorted(path.stem for path in FOLDER.glob("*.yaml"))


@cache
def published(key: str) -> Published | None:
    """The figures of one file; None for the empty key.

    The file names ``source``, ``corpus`` and ``metrics``. Its sections, none of which it must have: ``topologies``
    (``figures`` by stack and nodes; ``trained`` with ``stacks`` and ``nodes``), ``gains`` (``best``, ``figures`` by
    model), ``preference``, ``majority``, ``ratings`` (texts), ``selections`` (by name ``metrics``, and ``figures`` by
    row: for each measure mean and deviation; ``notes``), ``regions`` (``metrics``, ``digits``, ``rows`` with title,
    nodes, parameters, figures), ``emotions`` (number of utterances by emotion).

    Raises
    ------
    SettingError
        There is no such file, or a list of figures is not as long as the list of measures.
    """
    if not key:
        return None
    known = published_names()
    if key not in known:
        raise SettingError(f"`published: {key}` is not known. Known: {', '.join(known)}; leave it empty for none.")
    return published_of(read_yaml(FOLDER / f"{key}.yaml"), key)


def shared_metrics(paper: Published | None, metrics: Iterable[Metric]) -> tuple[str, ...]:
    """Names of the measures of a table beside published figures: the paper's, or where there is none, all given."""
    return paper.metrics if paper is not None and paper.metrics else tuple(metric.name for metric in metrics)


def published_of(data: Mapping, key: str) -> Published:
    """What a file of published figures says; ``key`` is its name in messages. Raises as :func:`published`."""
    metrics = tuple(metric_named(name).name for name in data.get("metrics", ()))

    def by_metric(figures) -> dict[str, float]:
        if len(figures) != len(metrics):
            raise SettingError(f"published/{key}.yaml: {figures} are not {len(metrics)} figures, one for each measure.")
        return dict(zip(metrics, figures, strict=True))

    topologies, gains = data.get("topologies", {}), data.get("gains", {})
    trained = topologies.get("trained", {})
    return Published(
        source=data["source"],
        corpus=data["corpus"],
        metrics=metrics,
        topologies={
            (stack, nodes): by_metric(figures)
            for stack, row in topologies.get("figures", {}).items()
            for nodes, figures in row.items()
        },
        stacks=tuple(trained.get("stacks", ())),
        nodes=tuple(trained.get("nodes", ())),
        gains={name: by_metric(figures) for name, figures in gains.get("figures", {}).items()},
        best=gains.get("best", ""),
        preference=data.get("preference", {}),
        majority=data.get("majority", {}),
        ratings=data.get("ratings", {}),
        selections={
            name: _selection(given, f"{key}.yaml: {name}") for name, given in data.get("selections", {}).items()
        },
        regions=_regions(data["regions"], f"{key}.yaml: regions") if "regions" in data else None,
        emotions=data.get("emotions", {}),
    )


def _regions(given: Mapping, where: str) -> PublishedRegions:
    metrics = tuple(metric_named(name).name for name in given["metrics"])
    for row in given["rows"]:
        if len(row["figures"]) != len(metrics):
            raise SettingError(
                f"published/{where}: {row['title']} must have a figure for each of {len(metrics)} measures."
            )
    rows = (
        (row["title"], int(row["nodes"]), str(row["parameters"]), dict(zip(metrics, row["figures"], strict=True)))
        for row in given["rows"]
    )
    return PublishedRegions(metrics, dict(zip(metrics, given["digits"], strict=True)), tuple(rows))


def _selection(given: Mapping, where: str) -> PublishedSelection:
    metrics = tuple(metric_named(name).name for name in given["metrics"])
    rows = {}
    for row, figures in given["figures"].items():
        if len(figures) != len(metrics) or any(len(one) != 2 for one in figures):
            raise SettingError(
                f"published/{where}: {row} must have mean and deviation for each of {len(metrics)} measures."
            )
        rows[str(row)] = {
            name: (float(mean), float(spread)) for name, (mean, spread) in zip(metrics, figures, strict=True)
        }
    digits = dict(zip(metrics, given["digits"], strict=True))
    return PublishedSelection(metrics, rows, digits, tuple(given.get("notes", ())))
