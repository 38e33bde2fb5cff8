"""Train the HMMs of one row of the tables, from those of the row before."""

from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.features.labels import read_phones
from visualspeech.jobs import job
from visualspeech.models.hmm.examples import TimedExamples, read_tracks
from visualspeech.models.hmm.model import Hmm, HmmSettings
from visualspeech.models.hmm.variants import train_variant
from visualspeech.provenance import file_digest
from visualspeech.storage import ArrayCollection, write_table

with job(snakemake.log[0]), ArrayCollection(snakemake.input.features) as features:
    utterances = read_utterances(snakemake.input.utterances)
    phones = read_phones(snakemake.input.phones)
    tracks = read_tracks(snakemake.input.alignment, phones)
    training, validation = (
        TimedExamples(features, [one.id for one in of_split(utterances, split)], tracks)
        for split in ("train", "validation")
    )
    hmm = train_variant(
        snakemake.wildcards.model,
        Hmm.load(snakemake.input.start[0]) if snakemake.input.start else None,
        training,
        validation,
        phones,
        HmmSettings(**snakemake.params.settings, seed=snakemake.params.seed),
        file_digest(snakemake.input.aam),
    )
    write_table(snakemake.output.curve, hmm.history_table())
    hmm.save(snakemake.output.hmm)
