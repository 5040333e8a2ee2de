"""Pause, step, jump, loop and stop: what keys do to playing, without any window."""

from dataclasses import dataclass

HELP = (
    "space pause · ←/→ step · page up/down 10 frames · home/end first/last · "
    "digits + enter jump · l loop · esc quit"
)
_MOVES = {"left": -1, "right": 1, "page_up": -10, "page_down": 10}


@dataclass
class Transport:
    """The state that keys change.

    numbers : frame numbers in the list's order
    at : place of the frame shown now
    """

    numbers: list[int]
    loop: bool = False
    paused: bool = False
    quit: bool = False
    at: int = 0
    typed: str = ""

    @property
    def count(self) -> int:
        """Frames in the list."""
        return len(self.numbers)

    def press(self, key: str) -> int | None:
        """Take one key; the place to go to, or None where playing just goes on.

        Stepping pauses; a jump keeps playing or paused as it is. Steps wrap around when looping.
        """
        if key.isdecimal():
            self.typed += key
            return None
        typed, self.typed = self.typed, ""
        if key in ("escape", "q"):
            self.quit = True
        elif key == "space":
            self.paused = not self.paused
        elif key == "l":
            self.loop = not self.loop
        elif key in _MOVES:
            self.paused = self.paused or key in ("left", "right")
            return self._place(self.at + _MOVES[key])
        elif key == "home":
            return 0
        elif key == "end":
            return self.count - 1
        elif key == "enter" and typed:
            # The frame of that number, or the nearest there is.
            wanted = int(typed)
            return min(range(self.count), key=lambda i: abs(self.numbers[i] - wanted))
        return None

    def _place(self, index: int) -> int:
        if self.loop:
            return index % self.count
        return min(max(index, 0), self.count - 1)
