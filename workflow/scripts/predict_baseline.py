"""Predict the appearance of the test utterances by means of training frames."""

from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.features.examples import Examples
from visualspeech.features.labels import read_phones
from visualspeech.jobs import job
from visualspeech.models.baselines import BaselineSettings, fit
from visualspeech.storage import ArrayCollection, ArrayWriter

with (
    job(snakemake.log[0]),
    ArrayCollection(snakemake.input.features) as features,
    ArrayWriter(snakemake.output[0]) as out,
):
    utterances = read_utterances(snakemake.input.utterances)
    training = Examples(features, [one.id for one in of_split(utterances, "train")])
    settings = BaselineSettings(**snakemake.params.settings)
    baseline = fit(snakemake.wildcards.model, training, len(read_phones(snakemake.input.phones)), settings)
    for one in of_split(utterances, "test"):
        predicted = baseline.predict(features.array(one.id, "labels"))
        out.add(one.id, {"appearance": predicted}, features.rate(one.id))
