"""Figures that papers print, to stand beside ours; each with its source, in ``published/*.yaml``."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from visualspeech.settings import read_yaml

FOLDER = Path(__file__).parent / "published"


@dataclass(frozen=True)
class Published:
    """What a paper prints.

    Parameters
    ----------
    source, corpus : for people
    metrics : names of the measures, in the order of its columns
    topologies : (stack, nodes) -> figures by measure (Table 1 of Fan 2015)
    stacks, nodes : what the paper trained, which may be more than it prints (its Table 2)
    systems : name of a system -> figures by measure (its Table 3)
    preference : answer -> share of the listeners (its Fig. 4)
    """

    source: str
    corpus: str
    metrics: tuple[str, ...]
    topologies: Mapping[tuple[str, int], Mapping[str, float]]
    stacks: tuple[str, ...]
    nodes: tuple[int, ...]
    systems: Mapping[str, Mapping[str, float]]
    preference: Mapping[str, float]


@cache
def published(experiment: str) -> Published | None:
    """What the paper of an experiment (``fan2015``) prints; None where nothing of it is kept here."""
    path = FOLDER / f"{experiment}.yaml"
    if not path.is_file():
        return None
    data = read_yaml(path)
    metrics = tuple(data["metrics"])
    return Published(
        source=data["source"],
        corpus=data["corpus"],
        metrics=metrics,
        topologies={
            (stack, nodes): dict(zip(metrics, figures, strict=True))
            for stack, row in data["table_1"].items()
            for nodes, figures in row.items()
        },
        stacks=tuple(data["table_2"]["stacks"]),
        nodes=tuple(data["table_2"]["nodes"]),
        systems={name: dict(zip(metrics, figures, strict=True)) for name, figures in data["table_3"].items()},
        preference=data["figure_4"],
    )
