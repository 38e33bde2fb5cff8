"""The vectors of the visual coding of markers of one shard at the system's frame rate."""

from visualspeech.features.targets import target_streams
from visualspeech.jobs import job
from visualspeech.storage.arrays import ArrayReader, ArrayWriter

with (
    job(snakemake.log[0]),
    ArrayReader(snakemake.input.parameters) as parameters,
    ArrayWriter(snakemake.output[0]) as out,
):
    for one in parameters.ids:
        visual = {"appearance": parameters.array(one, "appearance")}
        streams, rate = target_streams(visual, parameters.rate(one), snakemake.params.rate)
        out.add(one, streams, rate)
