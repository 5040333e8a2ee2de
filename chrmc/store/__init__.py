"""A hologram video on disk: its folder, its manifest, its one writer, what leaves it again."""
