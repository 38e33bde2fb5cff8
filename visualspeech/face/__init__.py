"""From video frames to landmarks, frontal faces and appearance parameters."""
