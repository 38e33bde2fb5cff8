"""What the input blocks of a system are made of, and which of its rows can read new speech."""

from collections.abc import Iterable, Mapping

from visualspeech.features.blocks.base import block_class, encoding_needs, is_segmental, parts_of, unavailable
from visualspeech.models.families import FAMILIES
from visualspeech.models.rows import ModelRow
from visualspeech.schema import unknown


def part_mistakes(blocks: Mapping[str, Mapping], where: str) -> list[str]:
    """Blocks that are to be computed from another one that the system lacks; a sentence for each.

    Parameters
    ----------
    blocks : name -> kind and settings, defaults filled in
    where : place of the system in the settings, for messages
    """
    found = []
    for name, block in blocks.items():
        for key, kind in parts_of(block_class(block["kind"])).items():
            known, named = [other for other, one in blocks.items() if one["kind"] == kind], block["settings"][key]
            if named not in known:
                found.append(unknown(f"{where}.blocks.{name}.{key}", named, known, f"input block of kind {kind}"))
    return found


def package_mistakes(blocks: Mapping[str, Mapping], where: str) -> list[str]:
    """Blocks that need a package which is not installed; a sentence for each. Arguments as of :func:`part_mistakes`."""
    missing = {name: unavailable(block_class(block["kind"])) for name, block in blocks.items()}
    return [
        f"`{where}.blocks.{name}.kind: {blocks[name]['kind']}` cannot be computed: {why}"
        for name, why in missing.items()
        if why
    ]


def viseme_number_mistakes(block: str, blocks: Mapping[str, Mapping], where: str) -> list[str]:
    """What is wrong with the block whose number of classes the target ``viseme_numbers`` varies; empty: the first."""
    known = [name for name, one in blocks.items() if one["kind"] == "dynamic_visemes"]
    if not block or block in known:
        return []
    return [unknown(f"{where}.viseme_numbers.block", block, known, "input block of kind dynamic_visemes")]


def segment_mistakes(rows: Iterable[ModelRow], blocks: Mapping[str, Mapping], where: str) -> list[str]:
    """Rows that are to read segments where their family reads frames, or the other way round; a sentence for each.

    Parameters
    ----------
    rows, blocks : of the system
    where : its place in the settings, for messages
    """
    segmental = {name: is_segmental(block_class(block["kind"])) for name, block in blocks.items()}
    found = []
    for row in rows:
        family = FAMILIES[row.family]
        for name in row.reads if not family.made_of else ():
            # A window of segments is a mistake of its own.
            if segmental[name] != family.segmental and not (segmental[name] and name in row.windows):
                has, reads = ("segments", "frames") if segmental[name] else ("frames", "segments")
                others = ", ".join(other for other in blocks if segmental[other] == family.segmental) or "none"
                found.append(
                    f"`{where}.models.{row.group}.reads: {name}` is an input block of {has}, and the family "
                    f"{row.family} reads {reads}. Known: {others}."
                )
    return list(dict.fromkeys(found))


def read_faces(reads: Iterable[str], blocks: Mapping[str, Mapping]) -> list[str]:
    """Of the blocks that a row reads, those that are computed from a recorded face, which new speech does not have."""
    found = []
    for name in reads:
        cls, settings = block_class(blocks[name]["kind"]), blocks[name]["settings"]
        if "faces" in encoding_needs(cls, settings) or read_faces([settings[key] for key in parts_of(cls)], blocks):
            found.append(name)
    return found


def speaking_row(rows: Iterable, blocks: Mapping[str, Mapping], shown: str) -> str:
    """Name of the row that speaks unless the run names one: the shown one, or the first model that reads no faces.

    Empty if no model can read new speech.
    """
    able = [row for row in rows if row.role != "floor" and not read_faces(row.reads, blocks)]
    names = [row.name for row in able if row.name == shown] + [row.name for row in able if row.role == "model"]
    return next(iter(names), "")


def speaking_mistakes(model: str, rows: Iterable[Mapping], blocks: Mapping[str, Mapping]) -> list[str]:
    """What is wrong with the row that is to speak new text; ``rows`` as plain data."""
    row = next(row for row in rows if row["name"] == model)
    faces = read_faces(row["reads"], blocks)
    if not faces:
        return []
    able = [row["name"] for row in rows if row["role"] == "model" and not read_faces(row["reads"], blocks)]
    others = ", ".join(able) or "the system has none"
    return [
        f"`speak.model: {model}` reads dynamic visemes of the recording (input block {', '.join(faces)}, `source: "
        f"oracle`), and new text has none; name a model with predicted ones: {others}."
    ]
