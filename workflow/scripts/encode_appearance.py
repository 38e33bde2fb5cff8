"""Code the faces of one shard as parameters of the visual coding."""

from visualspeech.face.coding_files import load_coding
from visualspeech.face.drift import Faces
from visualspeech.jobs import job, progress
from visualspeech.storage.arrays import ArrayReader, ArrayWriter

UNITS = {
    "points": "px of the normalised face, drift removed",
    "offset": "px of the normalised face, of the drift that was removed",
    "residual": "grey levels",
}

with (
    job(snakemake.log[0]),
    ArrayReader(snakemake.input.textures) as textures,
    ArrayWriter(snakemake.output[0]) as out,
):
    coding = load_coding(snakemake.input.aam)
    for one in progress(textures.ids, len(textures.ids), "utterances"):
        coded = coding.encode_faces(Faces.read(textures, one))
        arrays = {"appearance": coded.parameters, "offset": coded.offset.shape, **coded.details}
        out.add(one, arrays, textures.rate(one), UNITS)
