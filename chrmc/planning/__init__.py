"""Which method to take for a scene: costs, times this machine's rates, and expected errors."""
