"""Videos of test utterances: original, AAM reconstruction and prediction side by side, with sound."""

from pathlib import Path

from visualspeech.animation.video import Recording, Speaker, write_talking_head
from visualspeech.animation.video_settings import VideoSettings
from visualspeech.corpora.table import of_split, read_utterances
from visualspeech.face.drift import reference_face
from visualspeech.face.pose import Pose
from visualspeech.jobs import job, log, progress
from visualspeech.storage import ArrayCollection, ArrayReader, replacing

source, shown = snakemake.input, snakemake.params.settings
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
    if not snakemake.params.names["consent"]:
        log.warning("the corpus does not say whose face it holds and by what permission; add `consent:` to its file")
    speaker = Speaker.load(source.head, source.aam, source.reference)
    chosen = of_split(read_utterances(source.utterances), "test")[: shown["count"]]
    for one in progress(chosen, len(chosen), "videos"):
        turned = Pose.read(pose, one.id)
        recording = Recording(landmarks.array(one.id, "points"), turned, reference_face(textures, one.id))
        panels = {
            "AAM reconstruction": (parameters.array(one.id, "appearance"), parameters.rate(one.id)),
            "prediction": (predictions.array(one.id, "appearance"), predictions.rate(one.id)),
        }
        settings, path = VideoSettings(label=shown["label"]), Path(folder, f"{one.id}.mp4")
        write_talking_head(path, one, recording, panels, speaker, **snakemake.params.names, settings=settings)
