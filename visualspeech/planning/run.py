"""All settings of a run, resolved once: layers, defaults, systems, codings and corpora, checked before any job.

A run's settings come from ``config.yaml``, from ``--configfile`` and ``--config`` over it, and from the files that they
name: corpora, systems, codings. What comes out is complete: rules hold no defaults.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path

from visualspeech.errors import SettingError
from visualspeech.planning.corpora import CorpusPlan, plan_corpus
from visualspeech.planning.systems import (
    absolute_root,
    check_coding,
    check_speaker,
    complete_system,
    missing_needs,
    read_named,
    read_systems,
)
from visualspeech.schema import check, fill_defaults, load_schema

#: Folders beside the systems' in a corpus's results; no system may have such a name.
RESERVED = ("alignment", "audio", "benchmarks", "check", "codings", "corpus", "heads", "landmarks", "logs", "pose",
            "recordings", "tables", "truth")  # fmt: skip


def resolve(config: Mapping, folder: Path) -> dict:
    """All settings of a run from what the user gave; ``folder`` is the repository's ``config`` folder.

    Returns
    -------
    The run's settings with all defaults; ``corpora``, ``systems`` and ``codings`` are mappings by name.

    Raises
    ------
    SettingError
        A key is unknown or mistyped, a value is of the wrong kind, or a named file does not exist.
    """
    schemas = folder.parent / "workflow" / "schemas"
    run_schema = load_schema(schemas / "run.schema.yaml")
    check(config, run_schema)
    settings = fill_defaults(config, run_schema)
    override = settings["override"]
    systems, codings = read_systems(
        _listed(settings["systems"]), override.get("codings") or {}, override.get("systems") or {}, folder
    )
    corpora = [
        absolute_root(_unwrapped(read_named(one, "corpora", folder / "corpora")), one, folder / "corpora")
        for one in _listed(settings["corpora"])
    ]
    systems = _checked(systems, "systems", load_schema(schemas / "system.schema.yaml"))
    codings = _checked(codings, "codings", load_schema(schemas / "coding.schema.yaml"))
    for coding in codings.values():
        check_coding(coding)
    corpora = _checked(_by_name(corpora, "corpora"), "corpora", load_schema(schemas / "corpus.schema.yaml"))
    shares = settings["split"]
    if abs(sum(shares.values()) - 1) > 1e-6:
        raise SettingError(f"`split`: the shares must sum to 1, they sum to {sum(shares.values()):g}.")
    for name in systems:
        if name.lower() in RESERVED:
            raise SettingError(f"`systems`: {name} is the name of a folder of the results; give the system another.")
    systems = {name: complete_system(system, settings["seed"]) for name, system in systems.items()}
    check_speaker(settings["speak"], systems)
    return {**settings, "corpora": corpora, "systems": systems, "codings": codings}


def _listed(given) -> list:
    return list(given) if isinstance(given, list | tuple) else [given]


def _unwrapped(corpus: dict) -> dict:
    """A corpus's file may be a whole overlay, whose one corpus is then meant."""
    inner = corpus.get("corpora")
    if isinstance(inner, list) and len(inner) == 1 and isinstance(inner[0], dict):
        return {"name": corpus["name"], **inner[0]}
    return corpus


def _by_name(entries: Sequence[dict], key: str) -> dict[str, dict]:
    found: dict[str, dict] = {}
    for entry in entries:
        name = str(entry["name"])
        if name.lower() in map(str.lower, found):
            raise SettingError(f"`{key}` names {name} more than once (capitals do not count); give each its own name.")
        found[name] = entry
    return found


def _checked(entries: Mapping[str, dict], key: str, schema: Mapping) -> dict[str, dict]:
    """Entries that fit a schema, with all defaults filled in.

    Raises
    ------
    SettingError
        They do not fit; the messages name the place below ``key``.
    """
    check(
        {key: dict(entries)},
        {"type": "object", "properties": {key: {"type": "object", "additionalProperties": schema}}},
    )
    filled = {}
    for name, entry in entries.items():
        try:
            filled[name] = fill_defaults(entry, schema)
        except SettingError as error:
            raise SettingError(f"`{key}.{name}`: {error}") from error
    return filled


@dataclass(frozen=True)
class Plan:
    """What a run is to do.

    Parameters
    ----------
    settings : from :func:`resolve`
    corpora : name -> plan of the corpus
    pairs : (corpus, system) that are run
    skipped : a sentence for each pair that is not
    """

    settings: Mapping
    corpora: Mapping[str, CorpusPlan]
    pairs: tuple[tuple[str, str], ...]
    skipped: tuple[str, ...]

    def systems(self, corpus: str) -> list[str]:
        """Names of the systems that run on a corpus."""
        return [system for name, system in self.pairs if name == corpus]

    def codings(self, corpus: str) -> list[str]:
        """Names of the visual codings that these systems predict."""
        return list(dict.fromkeys(self.settings["systems"][name]["coding"] for name in self.systems(corpus)))


def plan_run(config: Mapping, folder: Path) -> Plan:
    """Settings, corpora, and which system runs on which corpus. Writes nothing.

    Raises
    ------
    SettingError, CorpusError
        As :func:`resolve` and :func:`plan_corpus`; or no selected system can run on a selected corpus.
    """
    settings = resolve(config, folder)
    corpora = {
        name: plan_corpus(corpus, settings["shards"], settings["split"], settings["seed"], settings["results"])
        for name, corpus in settings["corpora"].items()
    }
    pairs, skipped = [], []
    for corpus, system in product(corpora, settings["systems"]):
        missing = missing_needs(settings["systems"][system], corpora[corpus].gives)
        if missing:
            skipped.append(f"{system} is skipped on {corpus}: it needs {', '.join(missing)}.")
        else:
            pairs.append((corpus, system))
    if not pairs:
        raise SettingError(
            "no selected system can run on a selected corpus:\n" + "\n".join(f"  {one}" for one in skipped)
        )
    used = {corpus for corpus, _ in pairs}
    corpora = {name: corpus for name, corpus in corpora.items() if name in used}
    return Plan(settings, corpora, tuple(pairs), tuple(skipped))
