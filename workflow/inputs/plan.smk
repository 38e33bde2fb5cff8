# The plan of a run, and the input functions that several stages share.
import json
import os
import re

from snakemake.exceptions import WorkflowError
from snakemake.io import strip_wildcard_constraints
from snakemake.path_modifier import PathModifier
from snakemake.pathvars import Pathvars

from visualspeech.cluster import follow_run, name_run, settle_signals
from visualspeech.errors import VisualSpeechError
from visualspeech.jobs import settle_locks, settle_sigterm
from visualspeech.locks import hold
from visualspeech.planning.run import plan_run
from visualspeech.provenance import code_digest, digest
from visualspeech.settings import check_overlays, from_command_line, merged, read_yaml

if workflow.remote_exec:
    follow_run()


def of_module(given):
    """Settings of a run as a module: what it gives is laid over the default run. Its `prefix` and `replace_prefix` move
    the results as a whole, since paths stand in params too; other files, such as answers of viewers, stay where they are.
    """
    if not (ROOT / "config" / "config.yaml").is_file():
        raise WorkflowError("the `snakefile` of the module must be the Snakefile of a clone: settings lie beside it.")
    settings = merged(read_yaml(ROOT / "config" / "config.yaml"), given)
    if isinstance(settings["results"], str):
        settings["results"] = str(workflow.modifier.modify_path(f"{settings['results']}/")).rstrip("/")
    workflow.modifier.path_modifier = PathModifier(None, None, workflow)
    workflow.modifier.pathvars = Pathvars.with_defaults()
    return settings


try:
    if IS_MODULE:
        config = of_module(config)
    elif workflow.is_main_process:
        check_overlays(workflow.configfiles)
    PLAN = plan_run(from_command_line(config, {} if IS_MODULE else workflow.config_settings.config), ROOT / "config")
    if workflow.is_main_process:
        PLAN.check_alignments()
except VisualSpeechError as error:
    raise WorkflowError(str(error))

SETTINGS = PLAN.settings
# Those of this workflow, also when an input function of a module is called.
PATHVARS = workflow.pathvars
SEED = SETTINGS["seed"]
if workflow.is_main_process:
    for sentence in PLAN.skipped:
        logger.warning(sentence)


def codings_of_kind(kind):
    """Names of the visual codings of a kind."""
    return [name for name, one in SETTINGS["codings"].items() if one["kind"] == kind]


def systems_of_kind(kind):
    """Names of the systems that predict a visual coding of a kind."""
    return [name for name, one in SETTINGS["systems"].items() if one["coding"] in codings_of_kind(kind)]


LOCKS = []


def hold_corpora():
    """Hold the result folder of every corpus of the run; called when jobs are about to start."""
    if LOCKS:
        return
    folders = [f"{SETTINGS['results']}/{name}" for name in PLAN.corpora]
    run = name_run()
    try:
        LOCKS.extend(hold(folder, run) for folder in folders)
    except VisualSpeechError as error:
        raise WorkflowError(str(error))
    settle_locks(folders)
    os.environ[CODE] = json.dumps(DIGESTS)
    if workflow.local_exec:
        settle_sigterm()
    else:
        settle_signals()
    # Snakemake limits the jobs of a second, and for that looks for new jobs a second after each start of one, and again a
    # second after that, without end: after some hundred jobs this fills a good part of a core.
    workflow.scheduler.job_rate_limiter = None


def before_start(others):
    """Handler of the start of a run that first holds the corpora of a module; Snakemake calls no handler of a module."""

    def start(log):
        hold_corpora()
        others(log)

    return start


if IS_MODULE:
    workflow._onstart = before_start(workflow._onstart)


def refuse(sentence):
    """End the planning of a target that cannot be made. What an input function raises is shown with a traceback, unless
    it is an exit of the program."""
    raise SystemExit(sentence)


def one_of(names):
    """Regular expression of the given names."""
    return "|".join(dict.fromkeys(map(re.escape, names))) or "(?!)"


def plain(pattern):
    """A pattern with its path variables filled in, its wildcards without constraints."""
    return strip_wildcard_constraints(PATHVARS.apply(pattern))


def filled(pattern, wildcards, **more):
    """Paths of a pattern: path variables and wildcards filled in, one path for each combination of ``more``."""
    return expand(plain(pattern), **dict(wildcards.items()), **more)


def shards(pattern):
    """Input function: one path for each shard of the corpus that holds utterances."""
    return lambda wildcards: filled(pattern, wildcards, shard=PLAN.corpora[wildcards.corpus].shards)


def gives(wildcards, need):
    """Whether the job's corpus gives something, of ``NEEDS`` of the planning."""
    return need in PLAN.corpora[wildcards.corpus].gives


def shards_given(need, pattern):
    """Input function: as :func:`shards`; nothing where the corpus does not give ``need``."""
    return lambda wildcards: shards(pattern)(wildcards) if gives(wildcards, need) else []


def recordings(wildcards):
    """Input function: the folder that the demo corpus is recorded in. Files of users are no inputs: Snakemake would
    read wildcards, addresses and flags in their names; :func:`recordings_digest` stands for them."""
    folder = PLAN.corpora[wildcards.corpus].recorded_here.get(wildcards.shard)
    return [folder] if folder else []


def recordings_digest(wildcards):
    """Params function: digest of a shard's recordings, which re-runs its jobs where a recording changes."""
    return PLAN.corpora[wildcards.corpus].recordings(wildcards.shard)


def carried(function):
    """Params function: data of a job that Snakemake neither compares nor prints; :func:`marked` stands for it."""
    return lambda wildcards, input: function(wildcards)


def marked(function):
    """Params function: digest of what :func:`carried` hands to a job, which re-runs it where that changes."""
    return lambda wildcards: digest(function(wildcards))


# Digests of scripts. A job on another machine inherits those of its run: it would spend a third of its start on them.
CODE = "VISUALSPEECH_CODE"
DIGESTS = json.loads(os.environ.get(CODE, "{}")) if workflow.remote_exec else {}


def code(script, *modules, data=()):
    """Digest of the library code that a workflow script reaches; as a param it re-runs a rule when that code changes."""
    if not modules and not data:
        if script not in DIGESTS:
            DIGESTS[script] = code_digest(ROOT / "workflow" / "scripts" / script)
        return DIGESTS[script]
    return code_digest(ROOT / "workflow" / "scripts" / script, *modules, data=data)


def for_systems(pattern, **more):
    """Paths of a pattern for every corpus and the systems that run on it; ``more`` are functions of a system's name."""
    pattern = plain(pattern)
    return [
        path
        for corpus, system in PLAN.pairs
        for path in expand(
            pattern, corpus=corpus, system=system, **{name: values(system) for name, values in more.items()}
        )
    ]


def for_corpora(pattern, need=""):
    """Paths of a pattern for every corpus, or every one that gives ``need``, and where the pattern asks for them for its
    shards and its visual codings."""
    pattern = plain(pattern)
    paths = [
        path
        for name, corpus in PLAN.corpora.items()
        if not need or need in corpus.gives
        for path in expand(
            pattern,
            corpus=name,
            shard=corpus.shards,
            coding=PLAN.codings(name),
            speaker=list(corpus.speakers),
        )
    ]
    return list(dict.fromkeys(paths))


def utterances_of(wildcards):
    """The utterances of a shard as plain data."""
    return PLAN.corpora[wildcards.corpus].rows(wildcards.shard)


def alignment_of(wildcards):
    """Params function: settings of the alignment of the job's corpus."""
    return PLAN.corpora[wildcards.corpus].alignment.settings


def alignment_sources(wildcards):
    """What alignment reads beside settings and sound: phone set, dictionary, and the files of the job's shard."""
    corpus = PLAN.corpora[wildcards.corpus]
    return corpus.alignment.sources(corpus.ids(wildcards.shard))


def alignment_state(wildcards):
    """As :func:`alignment_sources`, with the state of the files."""
    corpus = PLAN.corpora[wildcards.corpus]
    return corpus.alignment.digest(corpus.ids(wildcards.shard))


def dictionary_of(wildcards):
    """Params function: path and phone set of the pronunciation dictionary of the job's corpus; empty for none."""
    return PLAN.corpora[wildcards.corpus].alignment.dictionary


def dictionary_state(wildcards):
    """As :func:`dictionary_of`, with the content of the file."""
    return PLAN.corpora[wildcards.corpus].alignment.dictionary_digest()


def is_written(wildcards):
    """Params function: whether transcripts are needed; not where words are read from files."""
    return gives(wildcards, "text") and not PLAN.corpora[wildcards.corpus].alignment.given


def has_text(wildcards):
    """Params function: whether the corpus gives transcripts, with which its speech is aligned."""
    return gives(wildcards, "text")


def motion_of(wildcards):
    """Params function: how the motion capture of the job's corpus is read."""
    return PLAN.corpora[wildcards.corpus].motion


def split_of(wildcards):
    """The split of a corpus: id -> train, validation or test."""
    return PLAN.corpora[wildcards.corpus].split
