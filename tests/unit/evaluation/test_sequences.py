"""Predictions on the frames of the camera."""

import numpy as np

from visualspeech.evaluation.sequences import OnFrames
from visualspeech.features.resampling import resample
from visualspeech.storage.arrays import ArrayReader, ArrayWriter


def test_predictions_of_another_rate_are_measured_on_the_frames_of_the_camera(tmp_path):
    """A straight line keeps its values at the camera's frames but at the ends, where the stream is constant."""
    recorded = np.arange(20, dtype=np.float32)[:, None] * [1.0, -2.0]
    for name, values, rate in (("camera", recorded, 25.0), ("model", resample(recorded, 25, 100), 100.0)):
        with ArrayWriter(tmp_path / f"{name}.h5") as out:
            out.add("u", {"appearance": values}, rate)
    with ArrayReader(tmp_path / "camera.h5") as camera, ArrayReader(tmp_path / "model.h5") as model:
        found = OnFrames(model, camera).array("u", "appearance")
        np.testing.assert_array_equal(OnFrames(camera, camera).array("u", "appearance"), recorded)
    assert found.shape == (20, 2)
    np.testing.assert_allclose(found[1:-1], recorded[1:-1], atol=1e-4)
