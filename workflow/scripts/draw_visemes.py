"""Faces of the most frequent classes of dynamic visemes."""

from visualspeech.evaluation.viseme_pictures import viseme_pictures
from visualspeech.face.aam.model import Aam
from visualspeech.face.aam.reference import Reference
from visualspeech.features.blocks.base import load_block
from visualspeech.jobs import job
from visualspeech.storage.files import replacing

source = snakemake.input
with job(snakemake.log[0]), replacing(snakemake.output[0]) as path:
    aam, reference = Aam.load(source.coding), Reference.load(source.reference)
    path.write_bytes(viseme_pictures(load_block(source.block).classes, aam, reference))
