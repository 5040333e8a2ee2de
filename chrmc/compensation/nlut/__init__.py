"""The motion-compensated NLUT videos that the paper compares."""
