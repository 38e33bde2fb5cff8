import os
from pathlib import Path

from snakemake.utils import min_version

from visualspeech.jobs import settle_environment, settle_messages, shell_prefix

min_version("9.20")

# Also where another workflow uses this one as a module.
ROOT = Path(str(workflow.current_basedir))
IS_MODULE = not workflow.modifier.is_main_snakefile()

settle_messages()
settle_environment(ROOT)
if not IS_MODULE:
    shell.prefix(shell_prefix())


configfile: str(ROOT / "config" / "config.yaml")


report: "workflow/report/workflow.rst"


include: "workflow/inputs/plan.smk"
include: "workflow/inputs/studies.smk"
include: "workflow/inputs/evaluations.smk"


# Where results lie; every path in the rules begins with one of these. A wildcard inside a path variable is constrained here.
pathvars:
    results=SETTINGS["results"],
    corpus=f"<results>/{{corpus,{one_of(PLAN.corpora)}}}",
    coding=f"<corpus>/codings/{{coding,{one_of(SETTINGS['codings'])}}}",
    aam=f"<corpus>/codings/{{coding,{one_of(codings_of_kind('aam'))}}}",
    markers=f"<corpus>/codings/{{coding,{one_of(codings_of_kind('markers'))}}}",
    system=f"<corpus>/{{system,{one_of(SETTINGS['systems'])}}}",
    aam_system=f"<corpus>/{{system,{one_of(systems_of_kind('aam'))}}}",
    marker_system=f"<corpus>/{{system,{one_of(systems_of_kind('markers'))}}}",
    model="<system>/models/{model}",
    evaluation=f"<corpus>/evaluations/{{evaluated,{one_of(one.name for one in PLAN.evaluated)}}}",
    study=f"<results>/{{corpus,{NOT_ANSWERED}{one_of(PLAN.corpora)}}}/studies/{{study,{one_of(SETTINGS['studies'])}}}",


wildcard_constraints:
    block=one_of(name for system in SETTINGS["systems"].values() for name in system["blocks"]),
    model=one_of(row["name"] for system in SETTINGS["systems"].values() for row in system["rows"]),
    speaker=one_of(name for corpus in PLAN.corpora.values() for name in corpus.speakers),
    shard=r"\d+",


include: "workflow/inputs/systems.smk"
include: "workflow/inputs/landmarks.smk"
include: "workflow/inputs/resources.smk"
include: "workflow/inputs/tables.smk"
include: "workflow/inputs/visemes.smk"
include: "workflow/inputs/report.smk"
include: "workflow/inputs/speaking.smk"
include: "workflow/inputs/messages.smk"
include: "workflow/rules/corpus.smk"
include: "workflow/rules/demo.smk"
include: "workflow/rules/alignment.smk"
include: "workflow/rules/landmarks.smk"
include: "workflow/rules/pose.smk"
include: "workflow/rules/motion.smk"
include: "workflow/rules/coding.smk"
include: "workflow/rules/markers.smk"
include: "workflow/rules/features.smk"
include: "workflow/rules/models.smk"
include: "workflow/rules/measures.smk"
include: "workflow/rules/tables.smk"
include: "workflow/rules/figures.smk"
include: "workflow/rules/visemes.smk"
include: "workflow/rules/videos.smk"
include: "workflow/rules/marker_videos.smk"
include: "workflow/rules/studies.smk"
include: "workflow/rules/evaluations.smk"
include: "workflow/rules/speak.smk"
include: "workflow/rules/report.smk"


onstart:
    hold_corpora()
    if PROGRESS:
        PROGRESS.starts([os.path.relpath(one) for one in log])


onsuccess:
    show_end()


onerror:
    show_failure()


# Named targets.
rule all:
    default_target: True
    input:
        for_corpora("<corpus>/check/findings.tsv"),
        for_corpora("<corpus>/alignment/textgrid"),
        tables_of_all(),
        for_systems("<system>/videos"),
        for_corpora("<corpus>/report.html"),


rule alignment:
    input:
        for_corpora("<corpus>/alignment/{shard}.tsv"),
        for_corpora("<corpus>/alignment/textgrid"),


rule landmarks:
    input:
        for_corpora("<corpus>/landmarks/{shard}.h5", need="video"),


rule pose:
    input:
        for_corpora("<corpus>/pose/{shard}.h5", need="video"),
        for_corpora("<corpus>/utterances.tsv"),


rule motion:
    input:
        for_corpora("<corpus>/motion/{shard}.h5", need="motion"),
        for_corpora("<corpus>/utterances.tsv"),


rule coding:
    input:
        for_corpora("<coding>/parameters/{shard}.h5"),
        for_corpora("<coding>/utterances.tsv"),


rule features:
    input:
        [
            path
            for corpus, system in PLAN.pairs
            for path in expand(
                plain("<system>/features/{block}/{shard}.h5"),
                corpus=corpus,
                system=system,
                block=blocks_read(system),
                shard=PLAN.corpora[corpus].shards,
            )
        ],


rule models:
    input:
        for_systems("<model>/predictions.h5", model=lambda system: [row.name for row in rows_of(system)]),


rule tables:
    input:
        tables_of_all(),


rule videos:
    input:
        for_systems("<system>/videos"),


rule speaker:
    input:
        speaker_folders,


rule speak:
    input:
        spoken_videos,


rule viseme_numbers:
    input:
        viseme_number_tables,


rule study:
    input:
        study_files,


rule study_evaluation:
    input:
        evaluated_folders,


rule report:
    input:
        for_corpora("<corpus>/report.html"),
