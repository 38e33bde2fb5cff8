"""Predict the validation and test utterances by one model."""

from importlib import import_module

from visualspeech.corpora.table import read_utterances
from visualspeech.features.examples import opened_blocks, streams_of
from visualspeech.jobs import job
from visualspeech.storage.arrays import ArrayCollection, ArrayWriter
from visualspeech.storage.models import read_model

source = snakemake.input
with (
    job(snakemake.log[0]),
    opened_blocks(source.features, snakemake.params.reads) as features,
    ArrayCollection(source.targets) as targets,
    ArrayWriter(snakemake.output[0]) as out,
):
    model = import_module(snakemake.params.module).restore(*read_model(source.model), source.model)
    for one in read_utterances(source.utterances):
        if one.split != "train":
            frames, rate = targets.length(one.id, "appearance"), targets.rate(one.id)
            predicted = model.predict(streams_of(one.id, features, frames), frames, rate)
            out.add(one.id, {"appearance": predicted}, rate)
