# The result tables of each system, and of all systems of a corpus.
FORMS = (".tsv", ".md", ".tex", ".html")


def facts_of(wildcards):
    """What every table of a system says that it was computed on, beside what the files tell."""
    coding = coding_of(wildcards)
    return {
        "corpus": wildcards.corpus,
        "system": wildcards.system,
        "coding": coding["name"],
        "drift": coding["drift"]["method"],
    }


def table_settings(wildcards):
    """Measures and digits of a system's tables."""
    tables = system_of(wildcards)["tables"]
    return {key: tables[key] for key in ("metrics", "digits", "ratio_digits")}


def plain_rows(roles=("model", "baseline", "floor"), names=None):
    """Params function: rows of a system as plain data, of the given roles or names."""

    def rows(wildcards):
        chosen = names(system_of(wildcards)) if names else None
        found = rows_of(wildcards.system, roles)
        return [row.plain() for row in found if chosen is None or row.name in chosen]

    return rows


def statistics_of(roles=("model", "baseline", "floor"), names=None):
    """Input function: the measured test utterances of these rows, in the order of :func:`plain_rows`."""
    rows = plain_rows(roles, names)
    return lambda wildcards: [
        path
        for row in rows(wildcards)
        for path in filled("<model>/statistics.tsv", wildcards, model=row["name"])
    ]


def of_topologies(system):
    """Names of the rows of the table of topologies, with the training mean that ratios are taken to."""
    return [*system["tables"]["topologies"], "training_mean"]


def of_gains(system):
    """Names of the rows of the table of gains."""
    gains = system["tables"]["gains"]
    return [*gains["candidates"], *gains["references"]]


def tables_of(system):
    """Names of a system's tables."""
    wanted = SETTINGS["systems"][system]["tables"]
    gains = wanted["gains"]
    return [
        "objective",
        *(["topologies"] if wanted["topologies"] else []),
        "comparisons",
        *(["gains"] if gains["candidates"] and gains["references"] else []),
    ]


def tables_of_all():
    """All tables of a run."""
    return for_systems("<system>/tables/{table}.tsv", table=tables_of) + for_corpora("<corpus>/tables/systems.tsv")


rule measure_model:
    input:
        utterances="<corpus>/utterances.tsv",
        coding=of_coding("model.safetensors"),
        predictions="<model>/predictions.h5",
        targets=shards("<system>/targets/{shard}.h5"),
    output:
        "<model>/statistics.tsv",
    log:
        "<system>/logs/measure_model/{model}.log",
    benchmark:
        "<system>/benchmarks/measure_model/{model}.tsv"
    threads: 1
    resources:
        mem_mb=1000,
        disk_mb=50,
    params:
        code=code("measure_model.py"),
    script:
        "../scripts/measure_model.py"


rule tabulate_results:
    input:
        utterances="<corpus>/utterances.tsv",
        coding=of_coding("model.safetensors"),
        statistics=statistics_of(),
    output:
        multiext("<system>/tables/objective", *FORMS),
    log:
        "<system>/logs/tabulate_results.log",
    params:
        rows=plain_rows(),
        facts=facts_of,
        settings=table_settings,
        bootstrap=lambda wildcards: system_of(wildcards)["tables"]["bootstrap"],
        seed=SEED,
        code=code("tabulate_results.py"),
    script:
        "../scripts/tabulate_results.py"


rule tabulate_topologies:
    input:
        utterances="<corpus>/utterances.tsv",
        coding=of_coding("model.safetensors"),
        statistics=statistics_of(names=of_topologies),
    output:
        multiext("<system>/tables/topologies", *FORMS),
    log:
        "<system>/logs/tabulate_topologies.log",
    params:
        rows=plain_rows(names=of_topologies),
        facts=facts_of,
        settings=table_settings,
        published=lambda wildcards: system_of(wildcards)["published"],
        code=code("tabulate_topologies.py"),
    script:
        "../scripts/tabulate_topologies.py"


rule compare_models:
    input:
        utterances="<corpus>/utterances.tsv",
        coding=of_coding("model.safetensors"),
        statistics=statistics_of(("model", "baseline")),
    output:
        multiext("<system>/tables/comparisons", *FORMS),
    log:
        "<system>/logs/compare_models.log",
    params:
        rows=plain_rows(("model", "baseline")),
        facts=facts_of,
        settings=table_settings,
        comparison=lambda wildcards: system_of(wildcards)["tables"]["comparison"],
        bootstrap=lambda wildcards: system_of(wildcards)["tables"]["bootstrap"],
        seed=SEED,
        code=code("compare_models.py"),
    script:
        "../scripts/compare_models.py"


rule tabulate_gains:
    input:
        utterances="<corpus>/utterances.tsv",
        coding=of_coding("model.safetensors"),
        statistics=statistics_of(names=of_gains),
        curves=of_rows("learning_curve.tsv", lambda system: system["tables"]["gains"]["candidates"]),
    output:
        multiext("<system>/tables/gains", *FORMS),
    log:
        "<system>/logs/tabulate_gains.log",
    params:
        rows=plain_rows(names=of_gains),
        candidates=lambda wildcards: system_of(wildcards)["tables"]["gains"]["candidates"],
        references=lambda wildcards: system_of(wildcards)["tables"]["gains"]["references"],
        facts=facts_of,
        settings=table_settings,
        published=lambda wildcards: system_of(wildcards)["published"],
        comparison=lambda wildcards: system_of(wildcards)["tables"]["comparison"],
        bootstrap=lambda wildcards: system_of(wildcards)["tables"]["bootstrap"],
        seed=SEED,
        code=code("tabulate_gains.py"),
    script:
        "../scripts/tabulate_gains.py"


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


rule tabulate_systems:
    input:
        utterances="<corpus>/utterances.tsv",
        codings=of_systems(of_coding("model.safetensors")),
        statistics=of_systems(statistics_of()),
    output:
        multiext("<corpus>/tables/systems", *FORMS),
    log:
        "<corpus>/logs/tabulate_systems.log",
    params:
        systems=lambda wildcards: [
            {
                "title": system_of(one)["title"] or one.system,
                "rows": plain_rows()(one),
                "statistics": statistics_of()(one),
                "coding": of_coding("model.safetensors")(one)[0],
                "facts": facts_of(one),
            }
            for one in systems_of(wildcards)
        ],
        bootstrap=lambda wildcards: system_of(systems_of(wildcards)[0])["tables"]["bootstrap"] | {"seed": SEED},
        digits=lambda wildcards: system_of(systems_of(wildcards)[0])["tables"]["digits"],
        code=code("tabulate_systems.py"),
    script:
        "../scripts/tabulate_systems.py"
