# The system, visual coding and row that a job belongs to.
from visualspeech.face.markers import LANDMARK_NAMES, read_marker_set
from visualspeech.face.point_sets import point_set_path
from visualspeech.features.blocks.base import block_class, block_module, needs_of, parts_of
from visualspeech.models.families import FAMILIES
from visualspeech.models.lips import WEIGHTS
from visualspeech.models.registry import code_modules
from visualspeech.models.rows import ROLES, ModelRow
from visualspeech.models.training_settings import FRAME_BATCHERS

PREDICTING = tuple(role for role in ROLES if role != "floor")


def system_of(wildcards):
    """Settings of the system that a job belongs to."""
    return SETTINGS["systems"][wildcards.system]


def coding_of(wildcards):
    """Settings of the visual coding that a job belongs to, or of its system's."""
    name = getattr(wildcards, "coding", None) or system_of(wildcards)["coding"]
    return SETTINGS["codings"][name]


def of_coding(file):
    """Input function: a file of the visual coding of the job's system."""
    return lambda wildcards: filled(f"<coding>/{file}", wildcards, coding=system_of(wildcards)["coding"])[0]


def of_coding_shards(file):
    """Input function: a file of every shard of the visual coding of the job's system."""
    return lambda wildcards: filled(
        f"<coding>/{file}",
        wildcards,
        coding=system_of(wildcards)["coding"],
        shard=PLAN.corpora[wildcards.corpus].shards,
    )


def rows_of(system, roles=ROLES):
    """The rows of a system's tables, in their order."""
    rows = [ModelRow.of(row) for row in SETTINGS["systems"][system]["rows"]]
    return [row for row in rows if row.role in roles]


def blocks_read(system):
    """Names of the input blocks that any row of a system reads."""
    return list(dict.fromkeys(name for row in rows_of(system) for name in row.reads))


def row_of(wildcards):
    """The row that a job trains or predicts."""
    return next(row for row in rows_of(wildcards.system) if row.name == wildcards.model)


def of_rows(file, names=None):
    """Input function: a file of each row of the system, or of those that ``names(system settings)`` gives."""

    def paths(wildcards):
        chosen = names(system_of(wildcards)) if names else [row.name for row in rows_of(wildcards.system)]
        return [path for name in chosen for path in filled(f"<model>/{file}", wildcards, model=name)]

    return paths


def features_of(wildcards):
    """Feature files that a model reads: all shards of its first input block, then of the second, and so on."""
    numbers = PLAN.corpora[wildcards.corpus].shards
    return [
        path
        for block in row_of(wildcards).reads
        for path in filled("<system>/features/{block}/{shard}.h5", wildcards, block=block, shard=numbers)
    ]


def alignment_of_lips(wildcards):
    """Alignment of all shards, if the training of a row asks for the closures of its utterances."""
    asked = any(row_of(wildcards).training.get(name) for name in WEIGHTS)
    return shards("<corpus>/alignment/{shard}.tsv")(wildcards) if asked else []


def block_of(wildcards):
    """Kind and settings of the input block that a job fits or encodes."""
    return system_of(wildcards)["blocks"][wildcards.block]


def needs_of_blocks(wildcards):
    """What each input block of a system is computed from."""
    return {name: needs_of(block_class(one["kind"])) for name, one in system_of(wildcards)["blocks"].items()}


def parts_of_block(wildcards):
    """Names of the other input blocks that a job's block is computed from."""
    own = block_of(wildcards)
    return [own["settings"][key] for key in parts_of(block_class(own["kind"]))]


def where_needed(need, pattern):
    """Input function: files of the job's shard, or of all shards, if its input block is computed from ``need``."""

    def paths(wildcards):
        if need not in needs_of(block_class(block_of(wildcards)["kind"])):
            return []
        own = {} if hasattr(wildcards, "shard") else {"shard": PLAN.corpora[wildcards.corpus].shards}
        return filled(pattern, wildcards, **own)

    return paths


def model_code(script):
    """Params function: digest of a script with the code of the families of the row and of the rows that it is made of,
    and of the input blocks that it reads."""

    def digest(wildcards):
        row, blocks = row_of(wildcards), system_of(wildcards)["blocks"]
        kinds = [block_module(blocks[name]["kind"]) for name in row.reads]
        return code(script, *code_modules(row, rows_of(wildcards.system)), *kinds)

    return digest


def speakers_with_heads(wildcards):
    """File names of the speakers whose heads are fitted: all of a corpus with video."""
    return list(PLAN.corpora[wildcards.corpus].speakers) if gives(wildcards, "video") else []


def heads_of(wildcards):
    """The heads of all speakers of the corpus; none where there is no video."""
    return filled("<corpus>/heads/{speaker}.safetensors", wildcards, speaker=speakers_with_heads(wildcards))


def recorded_faces(wildcards):
    """The faces of every shard as they are recorded: tracked landmarks, or motion capture."""
    stage = "landmarks" if gives(wildcards, "video") else "motion"
    return shards(f"<corpus>/{stage}/{{shard}}.h5")(wildcards)


def findings_of(wildcards):
    """Findings of the check and of every shard's alignment, and of its tracking and head pose, or its motion capture."""
    faces = ("landmarks", "pose") if gives(wildcards, "video") else ("motion",)
    stages = [shards(f"<corpus>/{stage}/{{shard}}.findings.tsv") for stage in ("alignment", *faces)]
    checked = filled("<corpus>/check/findings.tsv", wildcards)
    return [*checked, *(path for stage in stages for path in stage(wildcards))]


def faces_findings_of(wildcards):
    """Findings of every shard of the stages of a visual coding that read the recordings; markers have none."""
    coding = coding_of(wildcards)
    stages = ["textures", *(["fitted"] if is_fitted(coding) else [])] if coding["kind"] == "aam" else []
    return [path for one in stages for path in shards(f"<coding>/{one}/{{shard}}.findings.tsv")(wildcards)]


def is_fitted(coding):
    """Whether the faces of a visual coding are those that its AAM finds in each frame."""
    return coding["kind"] == "aam" and coding["source"] == "fit"


def drift_of(coding):
    """Method by which a visual coding removes drift."""
    return coding["drift"]["method"] if coding["kind"] == "aam" else "none"


def recorded_points(wildcards):
    """Input function: the recorded points of the job's shard, or of all shards: landmarks in the frontal frame, or motion
    capture where there is no video."""
    pattern = f"<corpus>/{'pose' if gives(wildcards, 'video') else 'motion'}/{{shard}}.h5"
    return filled(pattern, wildcards)[0] if hasattr(wildcards, "shard") else shards(pattern)(wildcards)


def recorded_names(wildcards):
    """Params function: names of the recorded points of a corpus, in their order."""
    corpus = PLAN.corpora[wildcards.corpus]
    return list(LANDMARK_NAMES if "video" in corpus.gives else corpus.markers.names)


def recorded_markers(wildcards):
    """Params function: the marker set of a coding on a corpus, with the names of the recorded points in their order."""
    corpus, points = PLAN.corpora[wildcards.corpus], coding_of(wildcards)["points"]
    pictured = "video" in corpus.gives
    return {
        "source": points if pictured else corpus.name,
        "regions": (read_marker_set(points) if pictured else corpus.markers).by_region(),
        "names": recorded_names(wildcards),
    }


def points_code(script):
    """Params function: digest of a script with the point set of the job's coding."""
    return lambda wildcards: code(script, data=[point_set_path(coding_of(wildcards)["points"])])


def faces(wildcards):
    """The file of the faces that a coding's parameters code, of the job's shard; of all shards where it has none."""
    name = getattr(wildcards, "coding", None) or system_of(wildcards)["coding"]
    pattern = plain(f"<coding>/{'fitted' if is_fitted(SETTINGS['codings'][name]) else 'textures'}/{{shard}}.h5")
    if hasattr(wildcards, "shard"):
        return pattern.format(corpus=wildcards.corpus, coding=name, shard=wildcards.shard)
    return expand(pattern, corpus=wildcards.corpus, coding=name, shard=PLAN.corpora[wildcards.corpus].shards)


TRAINED = one_of(row.name for name in SETTINGS["systems"] for row in rows_of(name, PREDICTING))
FLOORS = one_of(row.name for name in SETTINGS["systems"] for row in rows_of(name, ("floor",)))
