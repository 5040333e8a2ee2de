"""What was looked at before: undo and redo of the view."""

from typing import Generic, TypeVar

State = TypeVar("State")
LENGTH = 200


class History(Generic[State]):
    """States in the order they were seen, and a place among them."""

    def __init__(self, first: State) -> None:
        self._states = [first]
        self._place = 0

    @property
    def present(self) -> State:
        """The state at the place."""
        return self._states[self._place]

    def note(self, state: State) -> None:
        """This is what is seen now; what was undone before is forgotten when it is new."""
        if state == self.present:
            return
        self._states = [*self._states[: self._place + 1], state][-LENGTH:]
        self._place = len(self._states) - 1

    def undo(self) -> State | None:
        """The state before, or None at the beginning."""
        if self._place == 0:
            return None
        self._place -= 1
        return self.present

    def redo(self) -> State | None:
        """The state that was undone, or None."""
        if self._place == len(self._states) - 1:
            return None
        self._place += 1
        return self.present
