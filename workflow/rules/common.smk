# The plan of a run, and the input functions that several stages share.
import re

from snakemake.exceptions import WorkflowError

from visualspeech.errors import VisualSpeechError
from visualspeech.features.blocks.base import block_module
from visualspeech.models.registry import FAMILIES
from visualspeech.models.rows import ModelRow
from visualspeech.planning.corpora import hold
from visualspeech.planning.run import plan_run
from visualspeech.provenance import code_digest

try:
    PLAN = plan_run(config, Path(workflow.basedir, "config"))
except VisualSpeechError as error:
    raise WorkflowError(str(error))

SETTINGS = PLAN.settings
SEED = SETTINGS["seed"]
if workflow.is_main_process:
    for sentence in PLAN.skipped:
        logger.warning(sentence)


LOCKS = []


def hold_corpora():
    """Hold the result folder of every corpus of the run; called when jobs are about to start."""
    try:
        LOCKS.extend(hold(f"{SETTINGS['results']}/{name}") for name in PLAN.corpora)
    except VisualSpeechError as error:
        raise WorkflowError(str(error))


def one_of(names):
    """Regular expression of the given names."""
    return "|".join(dict.fromkeys(map(re.escape, names))) or "(?!)"


def filled(pattern, wildcards, **more):
    """Paths of a pattern: path variables and wildcards filled in, one path for each combination of ``more``."""
    return expand(workflow.pathvars.apply(pattern), **dict(wildcards.items()), **more)


def shards(pattern):
    """Input function: one path for each shard of the corpus that holds utterances."""
    return lambda wildcards: filled(pattern, wildcards, shard=PLAN.corpora[wildcards.corpus].shards)


def recordings(wildcards):
    """The files that a shard's jobs read: the media, or the folder that the demo corpus is recorded in."""
    return PLAN.corpora[wildcards.corpus].media[wildcards.shard]


def code(script, *modules, data=()):
    """Digest of the library code that a workflow script reaches; as a param it re-runs a rule when that code changes."""
    return code_digest(Path(workflow.basedir, "workflow", "scripts", script), *modules, data=data)


def system_of(wildcards):
    """Settings of the system that a job belongs to."""
    return SETTINGS["systems"][wildcards.system]


def coding_of(wildcards):
    """Settings of the visual coding that a job belongs to, or of its system's."""
    name = getattr(wildcards, "coding", None) or system_of(wildcards)["coding"]
    return SETTINGS["codings"][name]


def of_coding(file):
    """Input function: a file of the visual coding of the job's system."""
    return lambda wildcards: filled(f"<coding>/{file}", wildcards, coding=system_of(wildcards)["coding"])


def rows_of(system, roles=("model", "baseline", "floor")):
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


def model_code(script):
    """Params function: digest of a script with the code of the row's family and of the input blocks that it reads."""

    def digest(wildcards):
        row, blocks = row_of(wildcards), system_of(wildcards)["blocks"]
        kinds = [block_module(blocks[name]["kind"]) for name in row.reads]
        return code(script, FAMILIES[row.family].module, *kinds)

    return digest


def for_systems(pattern, **more):
    """Paths of a pattern for every corpus and the systems that run on it; ``more`` are functions of a system's name."""
    pattern = workflow.pathvars.apply(pattern)
    return [
        path
        for corpus, system in PLAN.pairs
        for path in expand(
            pattern, corpus=corpus, system=system, **{name: values(system) for name, values in more.items()}
        )
    ]


def for_corpora(pattern):
    """Paths of a pattern for every corpus, and where it asks for them for its shards and its visual codings."""
    pattern = workflow.pathvars.apply(pattern)
    paths = [
        path
        for name, corpus in PLAN.corpora.items()
        for path in expand(
            pattern,
            corpus=name,
            shard=corpus.shards,
            coding=PLAN.codings(name),
            speaker=list(corpus.speakers),
        )
    ]
    return list(dict.fromkeys(paths))
