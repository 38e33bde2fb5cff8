"""The parameters of the visual coding of one shard at the system's frame rate."""

from visualspeech.face.lips import opening_stream
from visualspeech.face.point_sets import read_point_set
from visualspeech.features.targets import target_streams
from visualspeech.jobs import job
from visualspeech.storage.arrays import ArrayReader, ArrayWriter

STREAMS = ("appearance", "shape", "texture", "points")

with (
    job(snakemake.log[0]),
    ArrayReader(snakemake.input.parameters) as parameters,
    ArrayWriter(snakemake.output[0]) as out,
):
    points = read_point_set(snakemake.params.points)
    for one in parameters.ids:
        visual = {name: parameters.array(one, name) for name in STREAMS}
        streams, rate = target_streams(visual, parameters.rate(one), snakemake.params.rate)
        lips = opening_stream(streams["points"], points)
        # The offset is that of the recording, not of a frame.
        out.add(one, {**streams, **lips, "offset": parameters.array(one, "offset", ...)}, rate)
