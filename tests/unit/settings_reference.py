"""Lines of the tables in config/README.md, made from the schemas: each key with its default, range and description."""

from collections.abc import Iterator, Mapping
from decimal import Decimal

from tests.paths import REPOSITORY
from visualspeech.animation.rendering import RenderSettings
from visualspeech.animation.walk import WalkSettings
from visualspeech.corpora.demo.recording import DemoSettings
from visualspeech.features.blocks.base import block_kinds
from visualspeech.fields import section_schema
from visualspeech.models.entries import ENTRY, entry_schema
from visualspeech.models.families import FAMILIES
from visualspeech.models.training_settings import PRESETS
from visualspeech.planning.systems import block_schema
from visualspeech.schema import load_schema

LIBRARY = (DemoSettings, RenderSettings, WalkSettings)


def run_tables() -> dict[str, Mapping]:
    """Title -> schema of every mapping with fixed keys in the schema files."""
    paths = sorted((REPOSITORY / "workflow" / "schemas").glob("*.yaml"))
    return {title: node for path in paths for title, node in _objects(load_schema(path), path.name.split(".")[0])}


def class_tables() -> dict[str, Mapping]:
    """Title -> schema of entries of models and of blocks, and of settings that only the library has."""
    common = {key: value for key, value in entry_schema("stack")["properties"].items() if key in ENTRY}
    tables = {"entry": {"properties": common, "required": ["family"]}}
    for family in FAMILIES:
        own = {key: value for key, value in entry_schema(family)["properties"].items() if key not in ENTRY}
        tables |= {f"family {family}": {"properties": own}} if own else {}
    for kind in block_kinds():
        own = {key: value for key, value in block_schema(kind)["properties"].items() if key != "kind"}
        tables |= {f"block {kind}": {"properties": own}} if own else {}
    return tables | {f"library {cls.section}": section_schema(cls) for cls in LIBRARY}


def reference_rows(title: str) -> list[str]:
    """The lines of one table: key, default, what it may be, description."""
    schema = (run_tables() | class_tables())[title]
    required = schema.get("required", ())
    return [
        f"| `{key}` | {_default(key, node, required)} | {_values(node)} | {node['description']} |"
        for key, node in schema["properties"].items()
    ]


def preset_line(optimiser: str) -> str:
    """What a preset of training changes, as a list for people."""
    changes = ", ".join(
        f"`{key}: {_default(key, {'default': value}, ())}`" for key, value in PRESETS[optimiser].items()
    )
    return f"`optimiser: {optimiser}` changes these defaults: {changes}."


def readme_rows() -> list[str]:
    """The lines of all tables of keys in config/README.md."""
    lines = (REPOSITORY / "config" / "README.md").read_text(encoding="utf-8").splitlines()
    return [line for line in lines if line.startswith("| `") and line.count(" | ") == 3]


def _objects(node: Mapping, title: str) -> Iterator[tuple[str, Mapping]]:
    if node.get("properties"):
        yield title, node
    inner = dict(node.get("properties", {}))
    if isinstance(node.get("additionalProperties"), Mapping):
        inner["<name>"] = node["additionalProperties"]
    for key, one in inner.items():
        yield from _objects(one, f"{title}.{key}")


def _default(key: str, node: Mapping, required) -> str:
    if key in required:
        return "required"
    value = node.get("default")
    if value in (None, {}, [], ""):
        return "-"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list) and len(value) > 3:
        return "all" if value == node["items"].get("enum") else f"{len(value)} of them"
    if isinstance(value, Mapping):
        return ", ".join(f"{name}: {inner}" for name, inner in value.items())
    if isinstance(value, list):
        return ", ".join(map(str, value))
    return value if isinstance(value, str) else _number(value)


def _values(node: Mapping) -> str:
    if node.get("enum"):
        return ", ".join(f"`{one}`" for one in node["enum"])
    kind = node.get("type", "string")
    if kind == "array":
        inner = _values(node["items"])
        return f"list of {inner}" if node["items"].get("enum") else f"list: {inner}"
    if kind in ("integer", "number"):
        return ("whole number" if kind == "integer" else "number") + f", {_range(node)}"
    names = {"string": "text", "boolean": "true, false", "object": "mapping", "array": "list"}
    return names[kind] if isinstance(kind, str) else " or ".join(names[one] for one in kind)


def _range(node: Mapping) -> str:
    low = f"{_number(node['minimum'])}" if "minimum" in node else f"above {_number(node['exclusiveMinimum'])}"
    high = f"{_number(node['maximum'])}" if "maximum" in node else f"below {_number(node['exclusiveMaximum'])}"
    return f"{low} to {high}"


def _number(value) -> str:
    return f"{int(value):,}" if value >= 10_000 else format(Decimal(f"{value:g}"), "f")
