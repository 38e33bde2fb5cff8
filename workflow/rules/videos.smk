def shown_model(file):
    """Input function: a file of the model that a system's videos show."""
    return lambda wildcards: filled(f"<model>/{file}", wildcards, model=system_of(wildcards)["videos"]["model"])


def faces(wildcards):
    """Files of the faces that a coding's parameters code: at the tracker's landmarks, or where the fitted AAM finds them."""
    name = getattr(wildcards, "coding", None) or system_of(wildcards)["coding"]
    folder = "fitted" if SETTINGS["codings"][name]["source"] == "fit" else "textures"
    pattern = f"<coding>/{folder}/{{shard}}.h5"
    numbers = [wildcards.shard] if hasattr(wildcards, "shard") else PLAN.corpora[wildcards.corpus].shards
    return [path for number in numbers for path in expand(
        workflow.pathvars.apply(pattern), corpus=wildcards.corpus, coding=name, shard=number)]
