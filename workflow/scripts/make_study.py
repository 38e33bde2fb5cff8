"""A viewing test: stimuli with meaningless names, what participants see, and the key apart from both."""

from pathlib import Path

from visualspeech.jobs import job, log
from visualspeech.storage.files import replacing
from visualspeech.study.making import common_utterances, make_study, write_made
from visualspeech.study.settings import StudySettings
from visualspeech.study.sources import Shown, opened_faces

source, params = snakemake.input, snakemake.params
study, conditions = params.study, params.study["conditions"]
with (
    job(snakemake.log[0]),
    replacing(snakemake.output.media) as media,
    opened_faces(source, params.codings, [one["name"] for one in conditions if one["model"]]) as faces,
):
    media.mkdir()
    if not params.names["consent"]:
        log.warning("the corpus does not say whose face it holds and by what permission; add `consent:` to its file")
    utterances = common_utterances(source.utterances)
    shown = [Shown(one["name"], one["coding"], one["model"]) for one in conditions]
    settings = StudySettings(**study["settings"])
    made = make_study(media, study["name"], settings, shown, utterances, faces, params.names, params.seed)
    split = {one.id: one.split for one in utterances}
    names = {"corpus": params.names["corpus"], "published": study["published"]}
    write_made(Path(snakemake.output.study).parent, made, conditions, split, params.seed, **names)
