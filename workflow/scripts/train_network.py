"""Train one network; a killed training goes on from its checkpoint to the same result."""

from pathlib import Path

from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.features.examples import Examples
from visualspeech.features.labels import read_phones
from visualspeech.jobs import job
from visualspeech.models.blstm import parse_stack
from visualspeech.models.training import train, training_settings
from visualspeech.provenance import file_digest
from visualspeech.storage import ArrayCollection, write_table

with (
    job(snakemake.log[0]),
    ArrayCollection(snakemake.input.features) as features,
    ArrayCollection(snakemake.input.parts) as parts,
):
    utterances = read_utterances(snakemake.input.utterances)
    richer = parts if snakemake.params.parts else None
    training, validation = (
        Examples(features, [one.id for one in of_split(utterances, split)], parts=richer)
        for split in ("train", "validation")
    )
    result = train(
        parse_stack(snakemake.wildcards.model, snakemake.params.b_nodes),
        read_phones(snakemake.input.phones),
        training,
        validation,
        rate=features.rate(training.ids[0]),
        settings=training_settings(**snakemake.params.settings, seed=snakemake.params.seed),
        checkpoint=snakemake.params.checkpoint,
        aam=file_digest(snakemake.input.aam),
        parts=snakemake.params.parts,
    )
    write_table(snakemake.output.curve, result.curve_table())
    result.network.save(snakemake.output.network)
    Path(snakemake.params.checkpoint).unlink(missing_ok=True)
