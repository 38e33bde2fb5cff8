"""The floor of every table: the true appearance parameters as if they were a prediction."""

from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.jobs import job
from visualspeech.storage import ArrayCollection, ArrayWriter

with (
    job(snakemake.log[0]),
    ArrayCollection(snakemake.input.features) as features,
    ArrayWriter(snakemake.output[0]) as out,
):
    for one in of_split(read_utterances(snakemake.input.utterances), "test"):
        out.add(one.id, {"appearance": features.array(one.id, "appearance")}, features.rate(one.id))
