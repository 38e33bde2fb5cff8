# What videos and reports show.
def is_pictured(system):
    """Whether a system predicts a picture of the face, and not markers alone."""
    return system in systems_of_kind("aam")


def shown_model(file):
    """Input function: a file of the model that a system's videos show."""
    return lambda wildcards: filled(f"<model>/{file}", wildcards, model=system_of(wildcards)["videos"]["model"])[0]


def of_head(wildcards):
    """The head of a corpus's one speaker."""
    speaker, *_ = PLAN.corpora[wildcards.corpus].speakers
    return filled("<corpus>/heads/{speaker}.safetensors", wildcards, speaker=speaker)[0]


def names_of(wildcards):
    """What a video says of the face that it shows."""
    return {"corpus": wildcards.corpus, "consent": PLAN.corpora[wildcards.corpus].consent}


def compared_models(wildcards):
    """Names of the models in a system's figure of trajectories."""
    return system_of(wildcards)["trajectories"]["models"]


def figures_of(wildcards):
    """The figures of a system: each the path of a picture and its caption."""
    titles = {row.name: row.title for row in rows_of(wildcards.system)}
    wanted = system_of(wildcards)["trajectories"]
    shown = ", ".join(titles[name] for name in wanted["models"])
    caption = f"Parameter {wanted['parameter']} of a test utterance, recorded and predicted ({shown})"
    paths = filled("<system>/figures/trajectories.png", wildcards) if wanted["models"] else []
    found = [[path, caption] for path in paths]
    if by_emotion(wildcards):
        compared = ", ".join(titles[name] for name in of_emotions(system_of(wildcards)))
        caption = f"Both measures by region of the face and emotion ({compared}), with their intervals"
        found += [[path, caption] for path in filled("<system>/figures/emotions.png", wildcards)]
    return found


def stages_of_coding(coding):
    """Rules that a visual coding comes from: those of the whole corpus, and those of each shard."""
    if coding["kind"] == "markers":
        return ["fit_markers"], ["encode_markers"]
    fitted = ["fit_faces"] if is_fitted(coding) else []
    return ["fit_reference", "fit_aam"], ["sample_textures", *fitted, "encode_appearance"]


def benchmarks_of(wildcards):
    """Benchmark files of every job that the results of a corpus come from."""
    corpus = PLAN.corpora[wildcards.corpus]
    faces = ["track_landmarks", "normalise_pose"] if "video" in corpus.gives else ["read_motion"]
    stages = ["check_recordings", "align_speech", *faces]
    stages += ["record_demo"] if corpus.adapter == "demo" else []
    paths = filled("<corpus>/benchmarks/{stage}/{shard}.tsv", wildcards, stage=stages, shard=corpus.shards)
    paths += filled("<corpus>/benchmarks/fit_head/{speaker}.tsv", wildcards, speaker=speakers_with_heads(wildcards))
    for coding in PLAN.codings(wildcards.corpus):
        whole, sharded = stages_of_coding(SETTINGS["codings"][coding])
        paths += filled("<coding>/benchmarks/{stage}.tsv", wildcards, coding=coding, stage=whole)
        paths += filled(
            "<coding>/benchmarks/{stage}/{shard}.tsv", wildcards, coding=coding, stage=sharded, shard=corpus.shards
        )
    for one in systems_of(wildcards):
        trained = [row.name for row in rows_of(one.system, PREDICTING)]
        paths += filled(
            "<system>/benchmarks/{stage}/{model}.tsv", one, stage=["train_model", "predict_model"], model=trained
        )
        rendering = "render_videos" if is_pictured(one.system) else "render_markers"
        paths += filled("<system>/benchmarks/{stage}.tsv", one, stage=rendering)
    return paths


def reported(wildcards):
    """What the report shows of each system of a corpus, with the paths of its files."""
    return [
        {
            "name": one.system,
            "title": system_of(one)["title"] or one.system,
            "facts": list(facts_of(one).items()),
            "tables": [forms_of(one, name) for name in tables_of(one) if name != "comparisons"],
            "comparisons": forms_of(one, "comparisons"),
            "comparison": system_of(one)["tables"]["comparison"],
            "bootstrap": {**system_of(one)["tables"]["bootstrap"], "seed": SEED},
            "lips": filled("<system>/lips_camera.tsv", one)[0],
            "costs": filled("<system>/costs.tsv", one)[0],
            "targets": shards("<system>/targets/{shard}.h5")(one),
            "rows": [row.plain() for row in rows_of(one.system)],
            "validation": of_models("validation.tsv", one, rows_of(one.system, ("model",))),
            "curves": of_models("learning_curve.tsv", one, curved_rows(one.system)),
            "utterances": of_coding("utterances.tsv")(one),
            "findings": of_coding("findings.tsv")(one),
            # An AAM, whose modes are shown.
            "coding": of_coding("model.safetensors")(one) if is_pictured(one.system) else "",
            "reference": of_coding("reference.safetensors")(one) if is_pictured(one.system) else "",
            "visemes": drawn_visemes(one),
            "model": system_of(one)["videos"]["model"],
            "own": own_metrics_of(one),
            "predictions": shown_model("predictions.h5")(one),
            "videos": filled("<system>/videos", one)[0],
            "figures": [path for path, _ in figures_of(one)],
            "captions": [caption for _, caption in figures_of(one)],
        }
        for one in systems_of(wildcards)
    ]


def forms_of(one, table):
    """All files of a table of a system on a corpus."""
    return [path for form in FORMS for path in filled(f"<system>/tables/{table}{form}", one)]


def of_models(file, one, rows):
    """A file of each of some rows of a system on a corpus, by the rows' names."""
    return {row.name: filled(f"<model>/{file}", one, model=row.name)[0] for row in rows}


def curved_rows(system):
    """Rows whose training has a learning curve over epochs."""
    return [row for row in rows_of(system) if row.training]


#: Keys of :func:`reported` that hold paths, lists of them, or mappings to them.
REPORTED_FILES = ("tables", "comparisons", "lips", "costs", "targets", "validation", "curves", "utterances", "findings",
                  "coding", "reference", "visemes", "predictions", "videos", "figures")  # fmt: skip


def reported_files(wildcards):
    """Every file that :func:`reported` names."""
    paths = [path for one in reported(wildcards) for key in REPORTED_FILES for path in texts_in(one[key])]
    return list(filter(None, dict.fromkeys(paths)))


def texts_in(value):
    """All texts in nested lists and mappings, without the keys."""
    inner = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return [value] if isinstance(value, str) else [text for one in inner for text in texts_in(one)]


def reported_settings(wildcards):
    """The settings that a report shows: all that is in effect for its corpus, defaults included."""
    named = {
        "corpora": [wildcards.corpus],
        "systems": PLAN.systems(wildcards.corpus),
        "codings": PLAN.codings(wildcards.corpus),
    }
    parts = {key: {name: SETTINGS[key][name] for name in names} for key, names in named.items()}
    return {key: parts.get(key, value) for key, value in SETTINGS.items() if key != "override"}
