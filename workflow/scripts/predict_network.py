"""Predict the appearance of the test utterances from their labels."""

from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.features.examples import labels_of
from visualspeech.jobs import job
from visualspeech.models.network import Network
from visualspeech.storage import ArrayCollection, ArrayWriter

with (
    job(snakemake.log[0]),
    ArrayCollection(snakemake.input.features) as features,
    ArrayCollection(snakemake.input.parts) as parts,
    ArrayWriter(snakemake.output[0]) as out,
):
    network = Network.load(snakemake.input.network)
    for one in of_split(read_utterances(snakemake.input.utterances), "test"):
        predicted = network.predict(labels_of(one.id, features, parts if network.parts else None))
        out.add(one.id, {"appearance": predicted}, features.rate(one.id))
