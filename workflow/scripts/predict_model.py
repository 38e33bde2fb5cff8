"""Predict the validation and test utterances by one model, and write how long each prediction took."""

from importlib import import_module

from visualspeech.corpora.table import read_utterances
from visualspeech.features.examples import opened_blocks, streams_of
from visualspeech.jobs import job
from visualspeech.models.speed import timed_predictions, write_speed
from visualspeech.storage.arrays import ArrayCollection, ArrayWriter
from visualspeech.storage.models import read_model

source, seconds = snakemake.input, []
with (
    job(snakemake.log[0]),
    opened_blocks(source.features, snakemake.params.reads) as features,
    ArrayCollection(source.targets) as targets,
    ArrayWriter(snakemake.output.predictions) as out,
):
    model = import_module(snakemake.params.module).restore(*read_model(source.model), source.model)
    ids = [one.id for one in read_utterances(source.utterances) if one.split != "train"]
    frames, rates = {one: targets.length(one, "appearance") for one in ids}, {one: targets.rate(one) for one in ids}
    given = ((one, streams_of(one, features, frames[one]), frames[one], rates[one]) for one in ids)
    for name, predicted, taken in timed_predictions(model.predict, given):
        out.add(name, {"appearance": predicted}, rates[name])
        seconds.append((name, taken))
    write_speed(snakemake.output.speed, seconds)
