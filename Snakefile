from pathlib import Path

from snakemake.utils import min_version

from visualspeech.jobs import settle_environment

min_version("9.0")

settle_environment(workflow.basedir)


configfile: str(Path(workflow.basedir, "config", "config.yaml"))


include: "workflow/rules/common.smk"
include: "workflow/rules/demo.smk"
include: "workflow/rules/corpus.smk"
include: "workflow/rules/alignment.smk"
include: "workflow/rules/landmarks.smk"
include: "workflow/rules/pose.smk"
include: "workflow/rules/aam.smk"
include: "workflow/rules/fitting.smk"
include: "workflow/rules/features.smk"
include: "workflow/rules/models.smk"
include: "workflow/rules/hmm.smk"
include: "workflow/rules/tables.smk"
include: "workflow/rules/comparisons.smk"
include: "workflow/rules/videos.smk"
include: "workflow/rules/preference.smk"
include: "workflow/rules/speak.smk"
include: "workflow/rules/report.smk"


wildcard_constraints:
    shard=r"\d+",
    model="|".join(MODELS + HMMS + BASELINES),


localrules:
    all,
    alignment,
    landmarks,
    pose,
    aam,
    features,
    models,
    tables,
    videos,
    preference,
    speaker,
    speak,
    report,


rule all:
    default_target: True
    input:
        f"{CORPUS}/check/findings.tsv",
        f"{CORPUS}/alignment/textgrid",
        expand(f"{RUN}/tables/{{table}}.tsv", table=TABLES),
        f"{RUN}/videos",
        f"{CORPUS}/report.html",


rule alignment:
    input:
        shards(f"{CORPUS}/alignment/{{shard}}.tsv"),
        f"{CORPUS}/alignment/textgrid",


rule landmarks:
    input:
        shards(f"{CORPUS}/landmarks/{{shard}}.h5"),


rule pose:
    input:
        shards(f"{RUN}/pose/{{shard}}.h5"),
        f"{RUN}/utterances.tsv",


rule aam:
    input:
        shards(f"{RUN}/aam/parameters/{{shard}}.h5"),


rule features:
    input:
        shards(f"{RUN}/features/{{shard}}.h5"),


rule models:
    input:
        expand(f"{RUN}/models/{{model}}/predictions.h5", model=MODELS + HMM_ROWS + BASELINES),


rule tables:
    input:
        expand(f"{RUN}/tables/{{table}}.tsv", table=TABLES),


rule videos:
    input:
        f"{RUN}/videos",


rule speaker:
    input:
        f"{RUN}/speakers/{SPEAK['model']}",


rule speak:
    input:
        expand(f"{RUN}/spoken/{{number}}.mp4", number=SENTENCES),


rule preference:
    input:
        f"{RUN}/preference/videos",


rule report:
    input:
        f"{CORPUS}/report.html",
