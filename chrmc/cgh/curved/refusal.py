"""What `curved` says no to."""


class Refusal(ValueError):
    """A tolerance that cannot be promised, or sums that would take too long: another way may do."""
