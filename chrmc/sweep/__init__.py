"""Many small videos, one for each combination of choices, and one table of what came out."""
