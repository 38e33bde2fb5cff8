"""HMMs as a family of models: each variant from the row before, through files, and what a row must give them."""

from dataclasses import replace

import numpy as np
import pytest

from tests.unit.models.examples import task
from tests.unit.models.hmm.speech import PHONES, utterances
from visualspeech.errors import DataError, StorageError
from visualspeech.features.blocks.phone_track import PhoneTrack
from visualspeech.features.blocks.triphone_state import TriphoneState
from visualspeech.features.examples import Example
from visualspeech.features.streams import Stream
from visualspeech.models import mean
from visualspeech.models.hmm import family
from visualspeech.models.registry import load_model

BLOCKS = {"track": PhoneTrack(PHONES)}
SMALL = {"states": 3, "rate": 50.0, "min_frames": 4.0, "mdl_factor": 0.5, "mge_epochs": 2, "monophone_iterations": 1}


def examples(number, seed=0):
    return [
        Example((Stream(index=track.contexts.astype(np.int16), starts=track.starts),), values, rate)
        for track, values, rate in utterances(number, seed)
    ]


TRAINING, VALIDATION, TEST = examples(20), examples(4, 5), examples(6, 7)


def fit(variant, parent=None, settings=None, validation=None, **more):
    given = {**SMALL, "variant": variant, **(settings or {})}
    validation = VALIDATION if validation is None else validation
    return family.fit(
        task("hmm", given, TRAINING, validation, BLOCKS, parents=[parent] if parent else [], coding="abc", **more)
    )


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """The three variants, each made from the file of the one before."""
    folder, before, paths = tmp_path_factory.mktemp("hmms"), None, {}
    for variant in ("monophone", "tied", "mge"):
        paths[variant] = folder / f"{variant}.safetensors"
        fit(variant, before).model.save(paths[variant])
        before = paths[variant]
    return paths


def error(model):
    return np.mean([np.mean((model.predict(*inputs(one)) - one.target) ** 2) for one in TEST])


def inputs(one):
    return one.streams, len(one.target), one.rate


def test_each_variant_from_the_file_of_the_one_before(files):
    models = {variant: load_model(path) for variant, path in files.items()}
    assert error(models["tied"]) < error(models["monophone"])
    for variant, model in models.items():
        assert model.hmm.settings.variant == variant
        assert (model.coding, model.blocks, model.rate, model.outputs) == ("abc", BLOCKS, 25.0, 2)
    history = models["mge"].hmm.history_table()
    assert history["stage"].unique().tolist() == ["monophone", "tied", "mge"]


def test_the_file_gives_the_same_predictions(files, tmp_path):
    fitted = fit("monophone")
    fitted.model.save(tmp_path / "again.safetensors")
    assert (tmp_path / "again.safetensors").read_bytes() == files["monophone"].read_bytes()
    again = load_model(tmp_path / "again.safetensors")
    for one in TEST:
        found = again.predict(*inputs(one))
        assert found.dtype == np.float32 and np.array_equal(found, fitted.model.predict(*inputs(one)))
    assert fitted.curve["stage"].tolist() == ["monophone"]
    streams, frames, rate = inputs(TEST[0])
    assert again.predict(streams, 2 * frames, 2 * rate).shape == (2 * frames, 2)


def test_settings_are_those_of_the_variant(files):
    fewer, more = (fit("tied", files["monophone"], {"mdl_factor": factor}).model.hmm for factor in (20.0, 0.1))
    assert fewer.tying.gaussians < more.tying.gaussians
    assert fewer.settings.mdl_factor == 20.0


def test_the_seed_is_that_of_the_row(files):
    one, other = (fit("mge", files["tied"], seed=seed).model.hmm for seed in (1, 2))
    assert other.settings.seed == 2 and not np.array_equal(one.gaussians.mean, other.gaussians.mean)


def test_what_a_variant_needs_is_asked_for(files, tmp_path):
    with pytest.raises(DataError, match="`models.model` is of the variant tied and needs `from`"):
        fit("tied")
    with pytest.raises(DataError, match="validation"):
        fit("mge", files["tied"], validation=[])
    with pytest.raises(DataError, match="no training utterance"):
        family.fit(task("hmm", {"variant": "monophone"}, blocks=BLOCKS))
    mean.fit(task("mean", training=TRAINING, blocks=BLOCKS)).model.save(tmp_path / "mean.safetensors")
    with pytest.raises(StorageError, match="mean.safetensors: it holds no phone HMMs"):
        fit("tied", tmp_path / "mean.safetensors")


@pytest.mark.parametrize("blocks", [{}, {"tri": TriphoneState(PHONES)}, {**BLOCKS, "more": PhoneTrack(PHONES)}])
def test_the_block_must_be_one_of_phone_contexts(blocks):
    with pytest.raises(DataError, match="`models.model.reads` must name one segmental block, of kind phone_track"):
        family.fit(task("hmm", {"variant": "monophone"}, TRAINING, VALIDATION, blocks))


def test_streams_that_do_not_fit_are_refused(files):
    model = load_model(files["monophone"])
    (stream,), frames, rate = inputs(TEST[0])
    with pytest.raises(DataError, match="no frame"):
        model.predict([stream], 0, rate)
    with pytest.raises(DataError, match="`track`: a class is outside its inventory"):
        model.predict([replace(stream, index=stream.index + 6)], frames, rate)
    with pytest.raises(DataError, match="`track`: the rows of a stream are frames, the model reads segments"):
        model.predict([replace(stream, starts=None)], frames, rate)
