"""The scale of each speaker's face, and the opening that counts as closed in the tracked training utterances."""

from visualspeech.corpora.records import legal_id
from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.evaluation.lip_rows import tracked_speakers
from visualspeech.evaluation.lip_statistics import write_speakers
from visualspeech.face.head import load_heads
from visualspeech.face.mouth import TRACKED, eye_distance
from visualspeech.jobs import job
from visualspeech.speech.alignment import alignments_of
from visualspeech.storage.arrays import ArrayCollection

source = snakemake.input
with job(snakemake.log[0]), ArrayCollection(source.faces) as faces:
    utterances = read_utterances(source.utterances)
    heads = load_heads(snakemake.params.speakers, source.heads)
    names = dict.fromkeys(one.speaker for one in utterances)
    eyes = {name: eye_distance(heads[legal_id(name)].mean_points) for name in names}
    training = of_split(utterances, "train")
    aligned = alignments_of(source.alignment, [one.id for one in training])
    write_speakers(snakemake.output[0], tracked_speakers(training, faces, TRACKED, aligned, eyes))
