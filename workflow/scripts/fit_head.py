"""Fit the 3-D mean face to the speaker, from landmarks of training utterances."""

from visualspeech.corpora.table import read_split
from visualspeech.face.pose import PoseSettings, fit_head, sample_landmarks
from visualspeech.jobs import job
from visualspeech.storage import ArrayCollection

with job(snakemake.log[0]), ArrayCollection(snakemake.input.landmarks) as landmarks:
    split = read_split(snakemake.input.split)
    settings = PoseSettings(**snakemake.params.settings)
    training = [one for one in landmarks.ids if split[one] == "train"]
    points, size = sample_landmarks(landmarks, training, settings, snakemake.params.seed)
    fit_head(points, size, settings).save(snakemake.output[0])
