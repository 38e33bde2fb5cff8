"""Extreme values at every key of the settings, and what a run says of them; for tests and for longer campaigns.

``cases(seed, count)`` draws cases, ``outcome(case)`` resolves the smallest run with one. Both run in-process.
"""

import random
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from itertools import product
from pathlib import Path
from unittest import mock

from tests.paths import REPOSITORY
from visualspeech.errors import SettingError
from visualspeech.features.blocks.base import block_kinds
from visualspeech.models.entries import entry_schema
from visualspeech.models.families import FAMILIES
from visualspeech.planning import run, systems
from visualspeech.planning.codings import coding_schema
from visualspeech.planning.systems import block_schema
from visualspeech.schema import load_schema
from visualspeech.settings import merged, read_yaml

CONFIG = REPOSITORY / "config"
VALUES = (
    0, -1, 1, 1e-300, 1e-9, 1e300, 1e12, 10**24, -(10**24), 10**400, float("nan"), float("inf"), -float("inf"), 0.5,
    "", "x", "x" * 300, "y" * 5000, "1e999999999", "name\n", "a/../b", "~nobodyhere/x", "a\0b", "\ud800", "🙂", "{x}",
    None, True, False, [], [[]], ["x"] * 3, [None], {}, {"x": 1}, {1: 2}, {"a": {"b": {"c": [1]}}}, ["x" * 300], [0],
    list(range(30000)), [f"x{i}" for i in range(5000)], {f"k{i}": i for i in range(1000)}, (1, 2), b"bytes", {1, 2},
    1 + 2j,
)  # fmt: skip


@dataclass(frozen=True)
class Case:
    """A value at a key.

    Parameters
    ----------
    key : as a message names it, its parts joined by dots
    path : of the key in the settings that are laid over the smallest run
    value : anything
    node : JSON Schema of the key
    """

    key: str
    path: tuple
    value: object
    node: Mapping


@dataclass(frozen=True)
class Outcome:
    """What a run said: ``accepted``, ``refused`` or ``crashed``, its message, and the time that it took in seconds."""

    kind: str
    message: str
    seconds: float


def cases(seed: int, count: int | None = None) -> Iterator[Case]:
    """All cases in random order, or the first ``count`` of them; every key comes once before one comes twice."""
    generator = random.Random(seed)
    rounds = [generator.sample(VALUES, len(VALUES)) for _ in keys()]
    ordered = [(number, place) for number, place in product(range(len(VALUES)), range(len(rounds)))]
    for number, place in ordered[:count]:
        key, path, node = keys()[place]
        yield Case(key, path, rounds[place][number], node)


def outcome(case: Case) -> Outcome:
    """What planning says of a case; never raises."""
    began = time.perf_counter()
    try:
        with mock.patch.object(run, "load_schema", _schema), mock.patch.object(systems, "read_yaml", _read):
            run.resolve(_laid(case.path, case.value), CONFIG)
        kind, message = "accepted", ""
    except SettingError as error:
        kind, message = "refused", str(error)
    except Exception as error:  # what must not happen
        kind, message = "crashed", repr(error)[:300]
    return Outcome(kind, message, time.perf_counter() - began)


@cache
def keys() -> tuple[tuple[str, tuple, Mapping], ...]:
    """Every key of the settings: as messages name it, its path in an overlay, and its schema."""
    system, coding = ("override", "systems", "fan2015"), ("override", "codings", "aam51")
    named = {name: _schema(REPOSITORY / "workflow" / "schemas" / f"{name}.schema.yaml") for name in run.KINDS.values()}
    found = list(_keys(_schema(REPOSITORY / "workflow" / "schemas" / "run.schema.yaml"), (), ""))
    found += _keys(named["corpus"], ("corpora", 0), "corpora.tiny")
    found += _keys(named["system"], system, "systems.fan2015")
    own = read_yaml(CONFIG / "codings" / "aam51.yaml")
    found += _keys(coding_schema(named["coding"], own), coding, "codings.aam51")
    for family in FAMILIES:
        entry = {"stack": "nets", "hmm": "hmm_monophone", "lookup": "phone_state_mean"}.get(family)
        if entry:
            found += _keys(entry_schema(family, blocks=["tri"]), (*system, "models", entry), f"models.{entry}")
    for kind in block_kinds():
        block = {"triphone_state": "tri", "phone_track": "track", "label_parts": "parts"}.get(kind)
        if block:
            found += _keys(block_schema(kind), (*system, "blocks", block), f"blocks.{block}")
    return tuple(found)


def _keys(node: Mapping, path: tuple, where: str) -> Iterator[tuple[str, tuple, Mapping]]:
    for key, inner in node.get("properties", {}).items():
        below = f"{where}.{key}" if where else key
        yield below, (*path, key), inner
        yield from _keys(inner, (*path, key), below)


def _laid(path: tuple, value) -> dict:
    """The settings of the smallest run with a value at a path."""
    settings = merged(_read(CONFIG / "config.yaml"), _read(CONFIG / "test.yaml"))
    if path[:1] == ("corpora",) and len(path) > 1:
        settings["corpora"][0][path[2]] = value
        return settings
    settings["override"]["systems"]["fan2015"]["videos"]["model"] = ""  # no row is named where rows change
    within = settings
    for key in path[:-1]:
        within = within.setdefault(key, {})
    within[path[-1]] = value
    return settings


@cache
def _schema(path: Path) -> dict:
    return load_schema(path)


@cache
def _text(path: Path) -> dict:
    return read_yaml(path)


def _read(path: Path) -> dict:
    return merged(_text(path), {})
