"""Fit the 3-D mean face to the speaker, from landmarks of training utterances."""

from visualspeech.corpora.table import read_split
from visualspeech.face.head import PoseSettings, fit_head
from visualspeech.face.sampling import sample_points
from visualspeech.jobs import job
from visualspeech.storage import ArrayCollection

with job(snakemake.log[0]), ArrayCollection(snakemake.input.landmarks) as landmarks:
    split = read_split(snakemake.input.split)
    settings = PoseSettings(**snakemake.params.settings)
    points, size = sample_points(
        landmarks, [one for one in landmarks.ids if split[one] == "train"], settings.max_frames
    )
    fit_head(points, size, settings).save(snakemake.output[0])
