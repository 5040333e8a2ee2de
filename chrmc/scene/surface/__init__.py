"""Opaque surfaces: sampled to body-fixed points, shaded, and seen through a z-buffer."""
