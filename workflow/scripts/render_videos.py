"""Videos of test utterances: original, AAM reconstruction and prediction side by side, with sound."""

from pathlib import Path

from visualspeech.animation.video import Recording, Speaker, write_talking_head
from visualspeech.animation.video_settings import VideoSettings
from visualspeech.corpora.findings import attempt
from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.jobs import job, log, progress
from visualspeech.storage.arrays import ArrayCollection, ArrayReader
from visualspeech.storage.files import replacing

source, params = snakemake.input, snakemake.params
with (
    job(snakemake.log[0]),
    replacing(snakemake.output[0]) as folder,
    ArrayReader(source.predictions) as predictions,
    ArrayCollection(source.landmarks) as landmarks,
    ArrayCollection(source.pose) as pose,
    ArrayCollection(source.textures) as textures,
    ArrayCollection(source.parameters) as parameters,
):
    folder.mkdir()
    if not params.names["consent"]:
        log.warning("the corpus does not say whose face it holds and by what permission; add `consent:` to its file")
    speaker, settings = Speaker.load(source.head, source.aam, source.reference), VideoSettings(label=params.label)
    chosen = of_split(read_utterances(source.utterances), "test")[: params.clips]
    for one in progress(chosen, len(chosen), "videos"):
        recording, path = Recording.read(landmarks, pose, textures, one.id), Path(folder, f"{one.id}.mp4")
        titled = {"AAM reconstruction": parameters, "prediction": predictions}
        panels = {title: (arrays.array(one.id, "appearance"), arrays.rate(one.id)) for title, arrays in titled.items()}
        made = attempt(
            one, "videos", write_talking_head, path, one, recording, panels, speaker, **params.names, settings=settings
        )
        for finding in made.findings:
            log.warning("no video of %s (%s): %s. %s", one.id, finding.file, finding.finding, finding.remedy)
