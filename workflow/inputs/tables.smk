# What the tables of systems and corpora are made from.
FORMS = (".tsv", ".md", ".tex", ".html")


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


def of_selection(wildcards):
    """Names of the rows of a table of chosen rows, with their repetitions."""
    return system_of(wildcards)["tables"]["selections"][wildcards.selection]["rows"]


def selected_rows(wildcards):
    """Rows of a table of chosen rows as plain data, in the order of the table."""
    rows = {row.name: row.plain() for row in rows_of(wildcards.system)}
    return [rows[name] for name in of_selection(wildcards)]


def statistics_of_selection(wildcards):
    """The measured test utterances of these rows, in the same order."""
    names = of_selection(wildcards)
    return filled("<model>/statistics.tsv", wildcards, model=names)


def tables_of(system):
    """Names of a system's tables."""
    wanted = SETTINGS["systems"][system]["tables"]
    gains = wanted["gains"]
    return [
        "objective",
        *(["topologies"] if wanted["topologies"] else []),
        "comparisons",
        "articulation",
        "resting",
        *(["gains"] if gains["candidates"] and gains["references"] else []),
        *(["ablation"] if wanted["ablation"]["rows"] else []),
        *(name for name, one in wanted["selections"].items() if one["rows"]),
    ]


def tables_of_all():
    """All tables of a run."""
    return for_systems("<system>/tables/{table}.tsv", table=tables_of) + for_corpora("<corpus>/tables/systems.tsv")


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
            "rate": system_of(one)["rate"],
            "utterances": of_coding("utterances.tsv")(one),
            "coding": of_coding("model.safetensors")(one),
            "facts": facts_of(one),
        }
        for one in systems_of(wildcards)
    ]
