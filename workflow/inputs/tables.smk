# What the tables of systems and corpora are made from.
FORMS = (".tsv", ".md", ".tex", ".html")


def table_files(stem, table, system="{system}"):
    """Output files of a table, in the order of :data:`FORMS`; its page also stands in the report of Snakemake."""
    labels = {"system": system, "table": table}
    shown = {"category": "{corpus}", "subcategory": "Tables", "labels": labels, "caption": "../report/table.rst"}
    return [report(path, **shown) if path.endswith(".html") else path for path in multiext(stem, *FORMS)]


def facts_of(wildcards):
    """What every table of a system says that it was computed on, beside what the files tell."""
    coding = coding_of(wildcards)
    return {
        "corpus": wildcards.corpus,
        "system": wildcards.system,
        "coding": coding["name"],
        "drift": drift_of(coding),
    }


def table_settings(wildcards):
    """Measures and digits of a system's tables."""
    tables = system_of(wildcards)["tables"]
    return {key: tables[key] for key in ("metrics", "digits", "ratio_digits")}


def own_metrics_of(wildcards):
    """Params function: the user's own measures of a system, described by their sources."""
    return system_of(wildcards)["own_metrics"]


def plain_rows(roles=ROLES, names=None):
    """Params function: rows of a system as plain data, of the given roles or names."""

    def rows(wildcards):
        chosen = names(system_of(wildcards)) if names else None
        found = rows_of(wildcards.system, roles)
        return [row.plain() for row in found if chosen is None or row.name in chosen]

    return rows


def statistics_of(roles=ROLES, names=None, file="statistics.tsv"):
    """Input function: a file of each of these rows, by default their measured test utterances, in the order of
    :func:`plain_rows`."""
    rows = plain_rows(roles, names)
    return lambda wildcards: [
        path for row in rows(wildcards) for path in filled(f"<model>/{file}", wildcards, model=row["name"])
    ]


def predictions_of_rows(roles):
    """Input function: predictions of the rows of given roles, in the order of :func:`plain_rows`."""
    rows = plain_rows(roles)
    return lambda wildcards: [
        path for row in rows(wildcards) for path in filled("<model>/predictions.h5", wildcards, model=row["name"])
    ]


def of_topologies(system):
    """Names of the rows of the table of topologies, with the training mean that ratios are taken to."""
    return [*system["tables"]["topologies"], "training_mean"]


def of_gains(system):
    """Names of the rows of the table of gains."""
    gains = system["tables"]["gains"]
    return [*gains["candidates"], *gains["references"]]


def of_ablation(system):
    """Names of the rows of the ablation table, with their repetitions."""
    cells = [cell for cells in system["tables"]["ablation"]["rows"].values() for cell in cells]
    return [row["name"] for row in system["rows"] if row["cell"] in cells]


def of_regions(system):
    """Names of the rows of the table by region of the face, with the training mean and the floor."""
    trivial = [row["name"] for row in system["rows"] if row["family"] == "mean" or row["role"] == "floor"]
    return list(dict.fromkeys([*system["tables"]["regions"]["rows"], *trivial]))


def of_emotions(system):
    """Names of the rows of the table by emotion."""
    return system["tables"]["emotions"]["rows"]


def trained_of_regions(wildcards):
    """Names of the rows of the table by region that have a model."""
    trained = [row.name for row in rows_of(wildcards.system, PREDICTING)]
    return [name for name in of_regions(system_of(wildcards)) if name in trained]


def of_trained(file):
    """Input function: a file of each of these rows, in the same order."""
    return lambda wildcards: filled(f"<model>/{file}", wildcards, model=trained_of_regions(wildcards))


def of_selection(wildcards):
    """Names of the rows of a table of chosen rows, with their repetitions."""
    return system_of(wildcards)["tables"]["selections"][wildcards.selection]["rows"]


def ordered_rows(names):
    """Params function: rows as plain data, in the order in which ``names(system settings)`` gives them."""

    def rows(wildcards):
        found = {row.name: row.plain() for row in rows_of(wildcards.system)}
        return [found[name] for name in names(system_of(wildcards))]

    return rows


def selected_rows(wildcards):
    """Rows of a table of chosen rows as plain data, in the order of the table."""
    return ordered_rows(lambda system: of_selection(wildcards))(wildcards)


def statistics_of_selection(wildcards):
    """The measured test utterances of these rows, in the same order."""
    names = of_selection(wildcards)
    return filled("<model>/statistics.tsv", wildcards, model=names)


def tables_of(one):
    """Names of the tables of a system on a corpus; ``one`` has both as wildcards."""
    wanted = system_of(one)["tables"]
    gains, regional = wanted["gains"], coding_of(one)["kind"] == "markers"
    return [
        *(["regions"] if wanted["regions"]["rows"] else []),
        "objective",
        *(["topologies"] if wanted["topologies"] else []),
        "comparisons",
        # Both read the lip points of an appearance model.
        *([] if regional else ["articulation", "resting"]),
        *(["emotions"] if by_emotion(one) else []),
        *(["gains"] if gains["candidates"] and gains["references"] else []),
        *(["ablation"] if wanted["ablation"]["rows"] else []),
        *(name for name, one in wanted["selections"].items() if one["rows"]),
    ]


def by_emotion(one):
    """Whether a system has a table by emotion on a corpus: it asks for one, and the corpus has emotions."""
    return bool(of_emotions(system_of(one))) and "emotion" in PLAN.corpora[one.corpus].gives


def tables_of_all():
    """All tables of a run."""
    pairs = [OfSystem(*pair) for pair in PLAN.pairs]
    own = [path for one in pairs for path in filled("<system>/tables/{table}.tsv", one, table=tables_of(one))]
    return own + for_corpora("<corpus>/tables/systems.tsv")


SELECTIONS = one_of(name for system in SETTINGS["systems"].values() for name in system["tables"]["selections"])


class OfSystem:
    """Wildcards of one system of a corpus, for the functions that take a job's."""

    def __init__(self, corpus, system):
        self.corpus, self.system = corpus, system

    def items(self):
        return (("corpus", self.corpus), ("system", self.system))


def systems_of(wildcards):
    """The systems of a corpus, each with the wildcards of its jobs."""
    return [OfSystem(wildcards.corpus, name) for name in PLAN.systems(wildcards.corpus)]


def of_systems(function):
    """Input function: what another one gives for each system of the corpus, one after the other."""
    return lambda wildcards: [path for one in systems_of(wildcards) for path in function(one)]


def tabulated(wildcards):
    """What the table across systems is made from."""
    return [
        {
            "title": system_of(one)["title"] or one.system,
            "rows": plain_rows()(one),
            "statistics": statistics_of(file="camera.tsv")(one),
            "lips": filled("<system>/lips_camera.tsv", one)[0],
            "costs": filled("<system>/costs.tsv", one)[0],
            "rate": system_of(one)["rate"],
            "utterances": of_coding("utterances.tsv")(one),
            "coding": of_coding("model.safetensors")(one),
            "facts": facts_of(one),
        }
        for one in systems_of(wildcards)
    ]
