from dataclasses import replace

import pytest
from visualspeech.models.hmm.variants import train_variant
from visualspeech.models.names import HMMS

from tests.unit.models.hmm.speech import PHONES, utterances
from visualspeech.errors import DataError, SettingError
from visualspeech.models.hmm.model import HmmSettings

SETTINGS = HmmSettings(states=3, rate=50.0, min_frames=4, mdl_factor=0.5, mge_epochs=2, monophone_iterations=1)


def test_each_variant_from_the_one_before():
    hmm = None
    for name in HMMS:
        hmm = train_variant(name, hmm, utterances(12), utterances(4, seed=5), PHONES, SETTINGS, "digest")
        assert f"hmm_{hmm.kind}" == name and hmm.aam == "digest"
    assert hmm.history_table()["stage"].unique().tolist() == ["monophone", "tied", "mge"]


def test_settings_are_those_of_the_variant():
    monophone = train_variant("hmm_monophone", None, utterances(12), [], PHONES, SETTINGS)
    fewer = train_variant("hmm_tied", monophone, utterances(12), [], PHONES, replace(SETTINGS, mdl_factor=20.0))
    more = train_variant("hmm_tied", monophone, utterances(12), [], PHONES, replace(SETTINGS, mdl_factor=0.1))
    assert fewer.tying.gaussians < more.tying.gaussians
    assert fewer.settings.mdl_factor == 20.0


def test_unknown_variant_is_named():
    with pytest.raises(SettingError, match="hmm_tide"):
        train_variant("hmm_tide", None, [], [], PHONES, SETTINGS)


def test_what_a_variant_needs_is_asked_for():
    with pytest.raises(DataError, match="hmm_monophone, which is not given"):
        train_variant("hmm_tied", None, utterances(4), [], PHONES, SETTINGS)
    monophone = train_variant("hmm_monophone", None, utterances(4), [], PHONES, SETTINGS)
    with pytest.raises(DataError, match="validation"):
        train_variant("hmm_mge", monophone, utterances(4), [], PHONES, SETTINGS)
