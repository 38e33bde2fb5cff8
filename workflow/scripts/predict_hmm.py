"""Predict the appearance of the test utterances from their phones and the times of these, by HMMs."""

from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.jobs import job
from visualspeech.models.hmm.examples import read_tracks
from visualspeech.models.hmm.model import Hmm
from visualspeech.storage import ArrayCollection, ArrayWriter

with (
    job(snakemake.log[0]),
    ArrayCollection(snakemake.input.features) as features,
    ArrayWriter(snakemake.output[0]) as out,
):
    hmm = Hmm.load(snakemake.input.hmm)
    tracks = read_tracks(snakemake.input.alignment, hmm.phones)
    for one in of_split(read_utterances(snakemake.input.utterances), "test"):
        rate = features.rate(one.id)
        predicted = hmm.predict(tracks[one.id], features.length(one.id, "appearance"), rate)
        out.add(one.id, {"appearance": predicted}, rate)
