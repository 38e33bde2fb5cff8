# Material of a preference test (Fig. 4 of the paper), and what its listeners answered.
PREFERENCE = {
    "models": [SETTINGS["videos"]["model"], HMM_ROWS[-1] if HMM_ROWS else "triphone_state_mean"],
    "count": 10,
    "answers": "",
    **SETTINGS.get("preference", {}),
}
for name in PREFERENCE["models"]:
    if name not in PREDICTORS:
        raise WorkflowError(f"`preference.models: {name}` is not there. Known: {', '.join(PREDICTORS)}.")


rule render_pairs:
    input:
        utterances=f"{RUN}/utterances.tsv",
        aam=f"{RUN}/aam/model.safetensors",
        reference=f"{RUN}/aam/reference.safetensors",
        head=f"{RUN}/pose/head.safetensors",
        first=f"{RUN}/models/{PREFERENCE['models'][0]}/predictions.h5",
        second=f"{RUN}/models/{PREFERENCE['models'][1]}/predictions.h5",
        landmarks=shards(f"{CORPUS}/landmarks/{{shard}}.h5"),
        pose=shards(f"{RUN}/pose/{{shard}}.h5"),
        textures=shards(FACES),
    output:
        videos=directory(f"{RUN}/preference/videos"),
        sheet=f"{RUN}/preference/answers.tsv",
        # Not beside the videos: who shows them should not see it.
        key=f"{RUN}/preference_key.tsv",
    log:
        f"{RUN}/logs/render_pairs.log",
    benchmark:
        f"{RUN}/benchmarks/render_pairs.tsv"
    conda:
        "../envs/visualspeech.yaml"
    params:
        models=PREFERENCE["models"],
        pairs=PREFERENCE["count"],
        label=SETTINGS["videos"]["label"],
        names={"corpus": PLAN.name, "consent": SETTINGS["corpus"].get("consent", "")},
        seed=SEED,
        code=code("render_pairs.py"),
    script:
        "../scripts/render_pairs.py"


rule tally_preference:
    input:
        key=f"{RUN}/preference_key.tsv",
        answers=PREFERENCE["answers"] or f"{RUN}/preference/answers.tsv",
    output:
        multiext(f"{RUN}/tables/preference", ".tsv", ".md", ".tex", ".html"),
    log:
        f"{RUN}/logs/tally_preference.log",
    conda:
        "../envs/visualspeech.yaml"
    params:
        experiment=SETTINGS["experiment"],
        code=code("tally_preference.py"),
    script:
        "../scripts/tally_preference.py"
