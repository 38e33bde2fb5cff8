"""`aam_source` decides where the faces come from that are coded."""

from tests.workflow.running import TINY, planned_rules, snakemake


def test_fitting_is_planned_where_it_is_asked_for(tmp_path):
    assert "fit_faces" in planned_rules(tmp_path, "aam", "--config", "aam_source=fit")
    assert "fit_faces" not in planned_rules(tmp_path, "aam")


def test_another_source_remakes_the_parameters_and_not_the_model(tiny_run):
    rules = planned_rules(tiny_run, "features", "--config", "aam_source=fit")
    assert {"fit_faces", "encode_appearance", "build_features"} <= rules
    assert not rules & {"track_landmarks", "normalise_pose", "sample_textures", "fit_aam"}


def test_a_source_that_is_none_is_refused(tmp_path):
    done = snakemake(tmp_path, "--dry-run", "aam", "--config", "aam_source=tracker", configfiles=(TINY,))
    assert done.returncode != 0
    assert "aam_source" in done.stdout and "landmarks, fit" in done.stdout
