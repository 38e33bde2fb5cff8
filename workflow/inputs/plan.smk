# The plan of a run, and the input functions that several stages share.
import re

from snakemake.exceptions import WorkflowError
from snakemake.io import strip_wildcard_constraints

from visualspeech.errors import VisualSpeechError
from visualspeech.jobs import settle_locks, settle_sigterm
from visualspeech.locks import hold
from visualspeech.planning.run import plan_run
from visualspeech.provenance import code_digest, digest
from visualspeech.settings import check_overlays

try:
    if workflow.is_main_process:
        check_overlays(workflow.configfiles)
    PLAN = plan_run(config, Path(workflow.basedir, "config"))
    if workflow.is_main_process:
        PLAN.check_alignments()
except VisualSpeechError as error:
    raise WorkflowError(str(error))

SETTINGS = PLAN.settings
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
    folders = [f"{SETTINGS['results']}/{name}" for name in PLAN.corpora]
    try:
        LOCKS.extend(map(hold, folders))
    except VisualSpeechError as error:
        raise WorkflowError(str(error))
    settle_locks(folders)
    settle_sigterm()


def refuse(sentence):
    """End the planning of a target that cannot be made. What an input function raises is shown with a traceback, unless
    it is an exit of the program."""
    raise SystemExit(sentence)


def one_of(names):
    """Regular expression of the given names."""
    return "|".join(dict.fromkeys(map(re.escape, names))) or "(?!)"


def plain(pattern):
    """A pattern with its path variables filled in, its wildcards without constraints."""
    return strip_wildcard_constraints(workflow.pathvars.apply(pattern))


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


def code(script, *modules, data=()):
    """Digest of the library code that a workflow script reaches; as a param it re-runs a rule when that code changes."""
    return code_digest(Path(workflow.basedir, "workflow", "scripts", script), *modules, data=data)


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
