"""From a scene to a stored video: what decides its frames, and the making of them in groups."""
