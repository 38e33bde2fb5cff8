"""Labels and visual parameters of one shard at one frame rate."""

from visualspeech.features.labels import read_phones
from visualspeech.features.streams import FeatureSettings, feature_streams
from visualspeech.jobs import job
from visualspeech.speech.alignment import read_alignments
from visualspeech.storage import ArrayReader, ArrayWriter

STREAMS = ("appearance", "shape", "texture", "points")

with (
    job(snakemake.log[0]),
    ArrayReader(snakemake.input.parameters) as parameters,
    ArrayWriter(snakemake.output[0]) as out,
):
    phones = read_phones(snakemake.input.phones)
    settings = FeatureSettings(**snakemake.params.settings)
    alignments = read_alignments(snakemake.input.alignment)
    for one in parameters.ids:
        visual = {name: parameters.array(one, name) for name in STREAMS}
        streams, rate = feature_streams(alignments[one], visual, parameters.rate(one), phones, settings)
        out.add(one, streams, rate)
