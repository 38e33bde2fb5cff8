"""Tables and figures of the answers to a viewing test."""

from visualspeech.jobs import job, log
from visualspeech.study.evaluation import evaluate, summary, write_evaluation
from visualspeech.study.evaluation_settings import EvaluationSettings

params = snakemake.params
with job(snakemake.log[0]):
    evaluation = evaluate(params.folder, params.simulated, EvaluationSettings(**params.settings))
    write_evaluation(snakemake.output[0], evaluation)
    log.info("%s", summary(evaluation))
