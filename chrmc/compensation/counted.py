"""What a video method takes and how wrong its carrying is, reckoned before anything is computed."""

from dataclasses import dataclass

from chrmc.cgh.counts import OperationCounts


@dataclass(frozen=True)
class VideoCost:
    """Of a video method on a whole frame.

    cgh : the CGH method that is counted with it
    key, later : of a frame that is computed whole, and of the others
    serves : frames that a whole one serves, itself among them
    carried : relative error that carrying light from frame to frame adds to the CGH method's own
    """

    cgh: str
    key: OperationCounts
    later: OperationCounts
    serves: int
    carried: float = 0.0
