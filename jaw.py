# jaw.py
import numpy as np


def jaw_error(predicted, true, predicted_points, true_points):
    """Root mean square error of the lowest point of the face."""
    height = predicted_points[:, :, 1].max(axis=1) - true_points[:, :, 1].max(axis=1)
    return np.sqrt(np.mean((height - height.mean()) ** 2))


jaw_error.title = "Jaw error"
jaw_error.unit = "px"
