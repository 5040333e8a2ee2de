"""CH-RMC on a sphere around each object: exact for any rigid motion."""
