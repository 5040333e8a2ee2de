"""CH-RMC as published: one hologram on a curved plane, shifted for the next frames."""
