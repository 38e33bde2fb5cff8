"""Where the lips are in the recorded faces, the scale of each speaker, and the opening that counts as closed."""

from visualspeech.corpora.records import legal_id
from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.evaluation.tracked import mean_face, tracked_speakers, write_mouth, write_speakers
from visualspeech.face.head import load_heads
from visualspeech.face.mouth import eye_distance, find_mouth
from visualspeech.jobs import job
from visualspeech.speech.alignment import alignments_of
from visualspeech.storage.arrays import ArrayCollection

source, params = snakemake.input, snakemake.params
with job(snakemake.log[0]), ArrayCollection(source.faces) as faces:
    utterances = read_utterances(source.utterances)
    training = of_split(utterances, "train")
    ids = [one.id for one in training]
    mouth = find_mouth(params.names, lambda: mean_face(ids, faces))
    write_mouth(snakemake.output.mouth, mouth)
    heads = load_heads(params.speakers, source.heads)
    eyes = {speaker: eye_distance(head.mean_points) for speaker, head in heads.items()}
    known = {one.speaker: eyes.get(legal_id(one.speaker), float("nan")) for one in utterances}
    lips = mouth.among(params.names) if mouth.inner else None
    aligned = alignments_of(source.alignment, ids)
    write_speakers(snakemake.output.speakers, tracked_speakers(training, faces, lips, aligned, known))
