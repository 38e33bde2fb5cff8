"""Models by region of the face and emotion of the utterance: tables and a figure."""

from visualspeech.corpora.table import read_split, read_utterances
from visualspeech.evaluation.emotions import emotion_figure, emotion_frame, emotion_tables
from visualspeech.evaluation.facts import TableFacts
from visualspeech.evaluation.forms import all_forms
from visualspeech.evaluation.measured import MeasuredRows
from visualspeech.evaluation.published_results import published
from visualspeech.evaluation.region_settings import EmotionSettings
from visualspeech.evaluation.statistics import BootstrapSettings
from visualspeech.jobs import job
from visualspeech.storage.files import replacing, write_text
from visualspeech.storage.models import read_shapes
from visualspeech.storage.tables import read_numbers

source, params, made = snakemake.input, snakemake.params, snakemake.output
with job(snakemake.log[0]):
    measured = MeasuredRows.of(params.rows, [read_numbers(path) for path in source.statistics])
    facts = TableFacts.of(params.facts, read_split(source.utterances), read_shapes(source.coding), measured)
    emotions = {one.id: one.emotion for one in read_utterances(source.utterances)}
    settings, bootstrap = EmotionSettings(**params.settings), BootstrapSettings(**params.bootstrap, seed=params.seed)
    given = measured, emotions, settings
    frame = emotion_frame(*given, bootstrap)
    lines, paper = facts.lines(measured), published(params.published)
    tables = emotion_tables(frame, *given, lines, bootstrap, paper, params.digits, params.needs)
    for path, text in zip(made.tables, all_forms(frame, tables, "Emotions"), strict=True):
        write_text(path, text)
    with replacing(made.figure) as picture:
        picture.write_bytes(emotion_figure(frame, measured))
