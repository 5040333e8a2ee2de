"""What a panel will show of a scene, before a hologram is made."""
