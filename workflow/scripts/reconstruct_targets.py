"""The floor of every table: the true parameters of the visual coding as if they were a prediction."""

from visualspeech.corpora.table import read_utterances
from visualspeech.jobs import job
from visualspeech.storage.arrays import ArrayCollection, ArrayWriter

with (
    job(snakemake.log[0]),
    ArrayCollection(snakemake.input.targets) as targets,
    ArrayWriter(snakemake.output[0]) as out,
):
    for one in read_utterances(snakemake.input.utterances):
        if one.split != "train":
            out.add(one.id, {"appearance": targets.array(one.id, "appearance")}, targets.rate(one.id))
