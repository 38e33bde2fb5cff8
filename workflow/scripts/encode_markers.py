"""Code the markers of one shard as normalised vectors."""

from visualspeech.corpora.table import read_utterances
from visualspeech.face.marker_coding import MarkerCoding
from visualspeech.jobs import job
from visualspeech.storage.arrays import ArrayReader, ArrayWriter

UNITS = {"appearance": "standard deviations"}

source = snakemake.input
with (
    job(snakemake.log[0]),
    ArrayReader(source.faces) as faces,
    ArrayWriter(snakemake.output[0]) as out,
):
    coding = MarkerCoding.load(source.coding)
    chosen = coding.markers.positions_in(snakemake.params.given["names"], "the recordings")
    for one in read_utterances(source.utterances):
        if one.id in faces:
            coded = coding.encode(faces.array(one.id, "points")[:, chosen], one.speaker)
            out.add(one.id, {"appearance": coded}, faces.rate(one.id), UNITS)
