"""Light in free space: propagation, and what a pixelated panel can diffract."""
