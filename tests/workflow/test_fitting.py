"""`source` of a visual coding decides where the faces come from that are coded."""

import pytest

from tests.workflow.running import of_coding, overlay, planned_rules, snakemake

pytestmark = pytest.mark.xdist_group("workflow")


def test_fitting_is_planned_where_it_is_asked_for(tmp_path):
    assert "fit_faces" in planned_rules(tmp_path, "coding", configfiles=overlay(tmp_path, of_coding(source="fit")))
    assert "fit_faces" not in planned_rules(tmp_path, "coding")


def test_another_source_remakes_the_parameters_and_not_the_model(tiny_run, tmp_path):
    rules = planned_rules(tiny_run, "features", configfiles=overlay(tmp_path, of_coding(source="fit")))
    assert {"fit_faces", "encode_appearance", "build_targets", "encode_block"} <= rules
    assert not rules & {"track_landmarks", "normalise_pose", "sample_textures", "fit_aam"}


def test_an_unknown_source_is_refused(tmp_path):
    done = snakemake(tmp_path, "--dry-run", "coding", configfiles=overlay(tmp_path, of_coding(source="tracker")))
    assert done.returncode != 0
    assert "codings.aam51.source: tracker" in done.stdout and "landmarks, fit" in done.stdout
