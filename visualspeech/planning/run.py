"""All settings of a run, resolved once: layers, defaults, systems, codings and corpora, checked before any job.

A run's settings come from ``config.yaml``, from ``--configfile`` and ``--config`` over it, and from the files that they
name: corpora, systems, codings. What comes out is complete: rules hold no defaults.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from itertools import product
from pathlib import Path

from visualspeech.errors import SettingError
from visualspeech.fields import section_schema
from visualspeech.planning.alignment import corpus_alignment
from visualspeech.planning.blocks import speaking_mistakes
from visualspeech.planning.codings import coding_schema, complete_coding, kind_mistakes, no_picture, with_needs
from visualspeech.planning.corpora import CorpusPlan, plan_corpus
from visualspeech.planning.misplaced import misplaced, override_mistakes
from visualspeech.planning.paths import path_mistakes
from visualspeech.planning.studies import complete_study, read_studies
from visualspeech.planning.systems import (
    absolute_root,
    by_name,
    complete_system,
    input_mistakes,
    listed,
    missing_needs,
    read_named,
    read_systems,
)  # fmt: skip
from visualspeech.schema import fill_defaults, load_schema, mistakes, unknown
from visualspeech.settings import plain_data
from visualspeech.speech.alignment_settings import AlignmentSettings

#: Folders beside the systems' in a corpus's results; no system may have such a name.
RESERVED = ("alignment", "audio", "benchmarks", "check", "codings", "corpus", "heads", "landmarks", "logs", "motion",
            "pose", "recordings", "studies", "tables", "truth")  # fmt: skip
#: Keys that name files; what these say is checked with the files' own schemas.
SELECTING = ("corpora", "systems", "studies", "override")
KINDS = {"corpora": "corpus", "codings": "coding", "systems": "system", "studies": "study"}


def resolve(config: Mapping, folder: Path) -> dict:
    """All settings of a run from what the user gave; ``folder`` is the repository's ``config`` folder.

    Returns
    -------
    The run's settings with all defaults; ``corpora``, ``systems``, ``codings`` and ``studies`` are mappings by name.

    Raises
    ------
    SettingError
        A key is unknown or mistyped, a value is of the wrong kind, or a named file does not exist; a line for each
        mistake, all mistakes of one sort at once: first keys and values, then what does not go together.
    """
    schemas = {
        name: load_schema(folder.parent / "workflow" / "schemas" / f"{name}.schema.yaml")
        for name in ("run", *KINDS.values())
    }
    config = plain_data(config)
    elsewhere, override = misplaced(config, schemas, folder), config.get("override")
    found = [*elsewhere.values()]
    if wrong := override_mistakes(override, schemas, config, folder):
        found += wrong.values()
        override = {key: value for key, value in override.items() if key not in wrong}
    known = {key: value for key, value in config.items() if key not in elsewhere}
    known |= {"override": override} if "override" in known else {}
    found += mistakes(known, schemas["run"])
    if mistakes(known, _part(schemas["run"], SELECTING)):
        raise SettingError("\n".join(found))
    try:
        systems, codings, corpora, studies = _read(config, folder)
    except SettingError as error:
        raise SettingError("\n".join([*found, str(error)])) from error
    read = plain_data({"corpora": corpora, "codings": codings, "systems": systems, "studies": studies})
    for key, entries in read.items():
        for name, entry in entries.items():
            schema = schemas[KINDS[key]]
            schema = coding_schema(schema, entry) if key == "codings" else schema
            found += mistakes(entry, schema, f"{key}.{name}")
            found += input_mistakes(entry, f"{key}.{name}") if key == "systems" else []
            if key == "corpora" and isinstance(own := entry.get("alignment", {}), Mapping):
                found += mistakes(own, section_schema(AlignmentSettings), f"{key}.{name}.alignment")
    if found:
        raise SettingError("\n".join(found))
    settings = fill_defaults(config, schemas["run"])
    collect = _Collector()
    shares = settings["split"]
    if abs(sum(shares.values()) - 1) > 1e-6:
        collect.found.append(f"`split`: the shares must sum to 1, they sum to {sum(shares.values()):g}.")
    corpora = {name: fill_defaults(one, schemas["corpus"], f"corpora.{name}") for name, one in corpora.items()}
    aligned = {
        name: collect(corpus_alignment, config.get("alignment") or {}, one, f"corpora.{name}")
        for name, one in corpora.items()
    }
    corpora = {name: {**one, "alignment": aligned[name]} for name, one in corpora.items()}
    codings = {
        name: collect(complete_coding, coding, schemas["coding"], f"codings.{name}") for name, coding in codings.items()
    }
    systems = {
        name: collect(_complete_system, system, schemas["system"], settings["seed"]) for name, system in systems.items()
    }
    if not collect.found:
        own = {name: codings[system["coding"]] for name, system in systems.items()}
        collect.found += [said for name, system in systems.items() for said in kind_mistakes(system, own[name])]
        collect.found += _speak_mistakes(settings["speak"], systems, own)
        studies = {
            name: collect(complete_study, fill_defaults(one, schemas["study"], f"studies.{name}"), systems, codings)
            for name, one in studies.items()
        }
    if collect.found:
        raise SettingError("\n".join(collect.found))
    systems = {name: with_needs(system, own[name]) for name, system in systems.items()}
    complete = {**settings, "corpora": corpora, "systems": systems, "codings": codings, "studies": studies}
    if found := path_mistakes(complete):
        raise SettingError("\n".join(found))
    return complete


class _Collector:
    """Calls functions and keeps their errors, so that all of them are reported at once."""

    def __init__(self) -> None:
        self.found: list[str] = []

    def __call__(self, function, *arguments):
        try:
            return function(*arguments)
        except SettingError as error:
            self.found.append(str(error))


def _part(schema: Mapping, keys: Collection[str]) -> dict:
    """What an object's schema says of some of its keys."""
    return {
        "type": "object",
        "required": [key for key in keys if key in schema["required"]],
        "properties": {key: schema["properties"][key] for key in keys},
    }


def _read(config: Mapping, folder: Path) -> tuple[dict, dict, dict, dict]:
    """Systems, codings, corpora and studies of a run, each by name; only what it takes to read them is checked."""
    override = config.get("override", {})
    systems, codings = read_systems(config["systems"], override.get("codings", {}), override.get("systems", {}), folder)
    corpora = [
        (where, absolute_root(_unwrapped(read_named(one, where, folder / "corpora")), one, folder / "corpora"))
        for where, one in listed(config["corpora"], "corpora")
    ]
    studies = read_studies(config.get("studies", []), override.get("studies", {}), folder)
    return systems, codings, by_name(corpora, "corpora"), studies


def _unwrapped(corpus: dict) -> dict:
    """A corpus's file may be a whole overlay, whose one corpus is then meant."""
    inner = corpus.get("corpora")
    if isinstance(inner, list) and len(inner) == 1 and isinstance(inner[0], dict):
        return {"name": corpus["name"], **inner[0]}
    return corpus


def _complete_system(system: Mapping, schema: Mapping, seed: int) -> dict:
    where = f"systems.{system['name']}"
    if system["name"].lower() in RESERVED:
        raise SettingError(
            f"`{where}`: {system['name']} is the name of a folder of the results; give the system another."
        )
    if 0 < system["rate"] < 1:
        raise SettingError(
            f"`{where}.rate: {system['rate']}` must be 0, the video's own rate, or at least 1 and at most 1000."
        )
    return complete_system(fill_defaults(system, schema, where), seed)


def _speak_mistakes(speak: Mapping, systems: Mapping[str, Mapping], codings: Mapping[str, Mapping]) -> list[str]:
    """What is wrong with the system and the model that speak; ``codings`` are those of the systems, by their names."""
    pictured = [name for name in systems if codings[name]["kind"] == "aam"]
    system = speak["system"] or next(iter(pictured or systems))
    if system not in systems:
        return [unknown("speak.system", system, list(systems), "selected system")]
    if speak["system"] and system not in pictured:
        others = ", ".join(pictured) or "none is selected"
        return [
            f"`speak.system: {system}` cannot speak: {no_picture(system, codings[system])}. Systems that can: {others}."
        ]
    models = [row["name"] for row in systems[system]["rows"] if row["role"] != "floor"]
    if speak["model"] and speak["model"] not in models:
        return [unknown("speak.model", speak["model"], models, f"model of {system}")]
    own = systems[system]
    return speaking_mistakes(speak["model"], own["rows"], own["blocks"]) if speak["model"] else []


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

    def check_alignments(self) -> None:
        """Read the dictionaries of the corpora and some of their files of alignments.

        Raises
        ------
        SettingError, CorpusError
            They cannot be used.
        """
        for corpus in self.corpora.values():
            corpus.alignment.check()

    def systems(self, corpus: str) -> list[str]:
        """Names of the systems that run on a corpus."""
        return [system for name, system in self.pairs if name == corpus]

    def codings(self, corpus: str) -> list[str]:
        """Names of the visual codings that these systems predict."""
        return list(dict.fromkeys(self.settings["systems"][name]["coding"] for name in self.systems(corpus)))

    @property
    def studies(self) -> tuple[tuple[str, str], ...]:
        """(corpus, study) of every study that can be made: where all systems that it compares run."""
        return tuple(
            (corpus, name)
            for corpus in self.corpora
            for name, study in self.settings["studies"].items()
            if not study["problem"] and {one["system"] for one in study["conditions"]} <= set(self.systems(corpus))
        )


def plan_run(config: Mapping, folder: Path) -> Plan:
    """Settings, corpora, and which system runs on which corpus. Writes nothing.

    Raises
    ------
    SettingError, CorpusError
        As :func:`resolve` and :func:`plan_corpus`; or no selected system can run on a selected corpus.
    """
    settings = resolve(config, folder)
    corpora = {
        name: plan_corpus(
            corpus, corpus["shards"] or settings["shards"], settings["split"], settings["seed"], settings["results"]
        )
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
