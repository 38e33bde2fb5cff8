"""What maps labels to appearance parameters: networks and the baselines that keep them honest."""
