# Answered viewing tests that the run evaluates.
from visualspeech.planning.evaluations import answers_state


def evaluated_study(wildcards):
    """The study, with its folder, that an evaluation belongs to."""
    named = {(one.corpus, one.name): one for one in PLAN.evaluated}
    if (wildcards.corpus, wildcards.evaluated) not in named:
        refuse(f"no folder in `study_evaluation.folders` holds the study {wildcards.evaluated} of {wildcards.corpus}.")
    return named[wildcards.corpus, wildcards.evaluated]


def evaluation_folder(wildcards):
    """Params function: folder of the answered study."""
    return evaluated_study(wildcards).folder


def answers_digest(wildcards):
    """Params function: digest of the files of a study, which are users' files and no inputs; it re-runs the evaluation
    where answers were added."""
    return digest(answers_state(evaluation_folder(wildcards), SETTINGS["study_evaluation"]["simulated"]))


def evaluation_settings(wildcards):
    """Params function: settings of the evaluation."""
    return {**SETTINGS["study_evaluation"]["statistics"], "seed": SEED}


def evaluations_of(wildcards):
    """Input function: the evaluated studies of a corpus."""
    names = [one.name for one in PLAN.evaluated if one.corpus == wildcards.corpus]
    return filled("<evaluation>", wildcards, evaluated=names) if names else []


def evaluated_folders(wildcards):
    """Input function: every evaluated study of the run."""
    if not PLAN.evaluated:
        refuse("no study is evaluated: name the folders of answered studies in `study_evaluation.folders`.")
    return [
        path for one in PLAN.evaluated for path in expand(plain("<evaluation>"), corpus=one.corpus, evaluated=one.name)
    ]
