"""Fit the 3-D mean face to one speaker, from landmarks of the speaker's training utterances."""

from visualspeech.corpora.records import legal_id
from visualspeech.corpora.table import read_split, read_utterances
from visualspeech.face.head import PoseSettings
from visualspeech.face.sampling import fit_speaker_head
from visualspeech.jobs import job
from visualspeech.storage.arrays import ArrayCollection

speaker = snakemake.wildcards.speaker
with job(snakemake.log[0]), ArrayCollection(snakemake.input.landmarks) as landmarks:
    utterances = [one for path in snakemake.input.utterances for one in read_utterances(path) if one.id in landmarks]
    split = read_split(snakemake.input.split)
    training = [one.id for one in utterances if legal_id(one.speaker) == speaker and split[one.id] == "train"]
    settings = PoseSettings(**snakemake.params.settings)
    fit_speaker_head(speaker, landmarks, training, settings).save(snakemake.output[0])
