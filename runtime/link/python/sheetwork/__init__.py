"""Live link to a running Sheetwork game: access to sheets in shared memory and to parameters.

    with sheetwork.attach() as game:
        for frame in game.frames(seconds=1):
            print(frame.time, frame.sheets[0].positions[:, 1].min())

Units: m, s, N, degrees Celsius. The protocol is described in docs/link.md of the project.
"""

from .client import (
    Full,
    Game,
    Grab,
    LinkError,
    NoGame,
    Refused,
    Silent,
    Unlike,
    attach,
)
from .layout import LAYOUT, Frame, Sheet, Topology

__all__ = [
    "Frame",
    "Full",
    "Game",
    "Grab",
    "LAYOUT",
    "LinkError",
    "NoGame",
    "Refused",
    "Sheet",
    "Silent",
    "Topology",
    "Unlike",
    "attach",
]
