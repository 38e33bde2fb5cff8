"""Code the faces of one shard as parameters of the active appearance model."""

from visualspeech.face.aam.model import Aam, reference_face
from visualspeech.face.drift import remove_shape
from visualspeech.jobs import job, progress
from visualspeech.storage import ArrayReader, ArrayWriter

UNITS = {"points": "px of the frontal picture, drift removed", "residual": "grey levels"}

with (
    job(snakemake.log[0]),
    ArrayReader(snakemake.input.textures) as textures,
    ArrayWriter(snakemake.output[0]) as out,
):
    aam = Aam.load(snakemake.input.aam)
    for one in progress(textures.ids, len(textures.ids), "utterances"):
        shape, face = textures.array(one, "shape"), reference_face(textures, one)
        coded = aam.encode_utterance(shape, textures.array(one, "texture"), face)
        arrays = {**coded._asdict(), "points": remove_shape(shape, face, aam.drift)}
        out.add(one, arrays, textures.rate(one), UNITS)
