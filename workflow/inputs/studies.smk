# Viewing tests: what each of them is made of, and which are left alone.
from visualspeech.study.records import is_answered

FROZEN = [
    (corpus, study) for corpus, study in PLAN.studies if is_answered(f"{SETTINGS['results']}/{corpus}/studies/{study}")
]
# What a path of a study begins with, unless people have answered it: no rule makes such a study any more, for its key
# would no longer fit the answers.
NOT_ANSWERED = f"(?!(?:{one_of(f'{corpus}/studies/{study}' for corpus, study in FROZEN)})/)"


class OfStudy:
    """Wildcards of a viewing test."""

    def __init__(self, corpus, study, coding=""):
        self.corpus, self.study, self.coding = corpus, study, coding

    def items(self):
        """As the wildcards of a job."""
        return {"corpus": self.corpus, "study": self.study, "coding": self.coding}.items()


def study_of(wildcards):
    """Settings and conditions of the viewing test that a job belongs to."""
    return SETTINGS["studies"][wildcards.study]


def codings_of_study(wildcards):
    """Visual codings of a viewing test, that of its own system first."""
    study = study_of(wildcards)
    names = [SETTINGS["systems"][study["system"]]["coding"], *(one["coding"] for one in study["conditions"])]
    return list(dict.fromkeys(filter(None, names)))


def of_study_codings(pattern, kind=""):
    """Input function: files of each visual coding of a viewing test, one coding after the other; none of those of
    another kind than ``kind``."""

    def paths(wildcards):
        return [
            path
            for coding in codings_of_study(wildcards)
            if not kind or SETTINGS["codings"][coding]["kind"] == kind
            for path in filled(pattern, wildcards, coding=coding, shard=PLAN.corpora[wildcards.corpus].shards)
        ]

    return lambda wildcards: list(dict.fromkeys(paths(wildcards)))


def faces_of_study(wildcards):
    """The file of the faces of every shard of each visual coding of talking heads."""
    found = [
        OfStudy(wildcards.corpus, wildcards.study, name)
        for name in codings_of_study(wildcards)
        if name in codings_of_kind("aam")
    ]
    return [path for one in found for path in faces(one)]


def where_pictured(function):
    """Input function: what another one gives if a viewing test shows talking heads, and nothing otherwise."""
    return lambda wildcards: function(wildcards) if codings_of_study(wildcards)[0] in codings_of_kind("aam") else []


def where_drawn(function):
    """Input function: what another one gives if a viewing test shows points and lines, and nothing otherwise."""
    return lambda wildcards: function(wildcards) if codings_of_study(wildcards)[0] in codings_of_kind("markers") else []


def predictions_of_study(wildcards):
    """The predictions of the conditions that are models, in their order."""
    return [
        path
        for one in study_of(wildcards)["conditions"]
        if one["model"]
        for path in filled("<model>/predictions.h5", wildcards, system=one["system"], model=one["model"])
    ]


def study_files(wildcards):
    """Input function: every viewing test of the run, but those that people have answered."""
    problems = [one for one in SETTINGS["studies"].values() if one["problem"]]
    for one in problems:
        if not one["skipped"]:
            refuse(one["problem"])
        logger.warning(one["problem"])
    for corpus, study in FROZEN:
        logger.warning(
            f"the study {study} of {corpus} is left as it is: people have answered it. Name a changed study otherwise."
        )
    if not PLAN.studies:
        refuse("no study can be made: name one in `studies` whose systems are selected and run on a corpus.")
    made = [one for one in PLAN.studies if one not in FROZEN]
    return [path for corpus, study in made for path in filled("<study>/study.json", OfStudy(corpus, study))]
