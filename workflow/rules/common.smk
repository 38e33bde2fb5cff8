# The plan of a run: settings, corpus and paths, and the input functions that several stages share.
from snakemake.exceptions import WorkflowError

from visualspeech import settings
from visualspeech.corpora.plan import hold, plan_corpus
from visualspeech.errors import VisualSpeechError
from visualspeech.face.aam.model import AamSettings
from visualspeech.models.names import BASELINES, HMMS
from visualspeech.features.label_parts import PARTS
from visualspeech.naming import parse_name
from visualspeech.provenance import code_digest

try:
    SETTINGS = settings.resolve(config, Path(workflow.basedir, "config"))
    AamSettings(**SETTINGS["aam"])  # more components than there can be are told now
    if workflow.is_main_process and not workflow.dryrun:
        LOCK = hold("results")
    PLAN = plan_corpus(SETTINGS["corpus"], SETTINGS["shards"], SETTINGS["split"], SETTINGS["seed"], "results")
except VisualSpeechError as error:
    raise WorkflowError(str(error))

CORPUS = f"results/{PLAN.name}"
RUN = f"{CORPUS}/{SETTINGS['experiment']}"
MODELS = settings.model_names(SETTINGS)
# The hidden Markov models in the tables, each made from the one before; the last one is the most refined.
HMM_ROWS = [name for name in HMMS if name in SETTINGS.get("hmm", {}).get("variants", [])]
PREDICTORS = [*MODELS, *HMM_ROWS, *(row for row in BASELINES if row != "aam_reconstruction")]
TABLES = ["objective", "topologies", "comparisons", *(["systems"] if HMM_ROWS else [])]
SEED = SETTINGS["seed"]
LABEL_PARTS = SETTINGS["networks"].get("label_parts", list(PARTS))

# The faces that the appearance parameters code: at the tracker's points, or at those that the fitted AAM finds.
FACES = f"{RUN}/aam/{'fitted' if SETTINGS.get('aam_source') == 'fit' else 'textures'}/{{shard}}.h5"


def network_seed(model):
    """Seed of a network's training, as its name says; without a word there, the first of the run."""
    named = parse_name(model).seed
    return settings.network_seeds(SETTINGS)[0] if named is None else named


def parts_of(wildcards):
    """Files of the label parts that a network reads; none for a network of plain labels."""
    return shards(f"{RUN}/label_parts/{{shard}}.h5") if parse_name(wildcards.model).rich else []


def shards(pattern):
    """One path a shard that holds utterances."""
    return expand(pattern, shard=PLAN.shards)


def recordings(wildcards):
    """The files that a shard's jobs read: the media, or the folder that the demo corpus is made in."""
    return PLAN.media[wildcards.shard]


def code(script):
    """Digest of the library code that a workflow script reaches; as a param it re-runs a rule when that code changes."""
    return code_digest(Path(workflow.basedir, "workflow", "scripts", script))
