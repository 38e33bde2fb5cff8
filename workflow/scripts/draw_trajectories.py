"""Figure of one parameter of a test utterance, recorded and as models predict it."""

from visualspeech.corpora.table import read_utterances
from visualspeech.evaluation.trajectory_figure import parameter_figure
from visualspeech.jobs import job
from visualspeech.storage.arrays import ArrayCollection
from visualspeech.storage.files import replacing

source, params = snakemake.input, snakemake.params
with (
    job(snakemake.log[0]),
    ArrayCollection(source.targets) as targets,
    replacing(snakemake.output[0]) as picture,
):
    predictions = dict(zip(params.titles, source.predictions, strict=True))
    utterances = read_utterances(source.utterances)
    png = parameter_figure(utterances, params.utterance, targets, predictions, source.alignment, params.parameter)
    picture.write_bytes(png)
