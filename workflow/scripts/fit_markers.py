"""Mean and deviation of each coordinate of the markers, from the training utterances."""

from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.face.marker_coding import MarkerSettings, fit
from visualspeech.face.markers import marker_set
from visualspeech.jobs import job
from visualspeech.storage.arrays import ArrayCollection

source, given = snakemake.input, snakemake.params.given
with job(snakemake.log[0]), ArrayCollection(source.faces) as faces:
    markers = marker_set(given["regions"], given["source"])
    chosen = markers.positions_in(given["names"], "the recordings")
    training = of_split(read_utterances(source.utterances), "train")
    recorded = ((one.speaker, faces.array(one.id, "points")[:, chosen]) for one in training)
    fit(recorded, markers, given["source"], MarkerSettings(**snakemake.params.settings)).save(snakemake.output[0])
