"""Services and companions of a zeronav stack in Python: the contract, and the loops that they share."""

from . import contract, geometry, messages
from .companion import Companion, Guest
from .controller import Controller, Scene
from .geometry import compose, free_ahead, then, wrap
from .inputs import CurrentGoal, MapInput, OdometryReader, Tasks
from .outputs import PathOutput, TaskProgress
from .parameters import param
from .planner import Planner, blocks_centre
from .program import NoConfig, run
from .service import Service
from .shell import IDLE, Due, Shell

__all__ = [
    "IDLE",
    "Companion",
    "Controller",
    "CurrentGoal",
    "Due",
    "Guest",
    "MapInput",
    "NoConfig",
    "OdometryReader",
    "PathOutput",
    "Planner",
    "Scene",
    "Service",
    "Shell",
    "TaskProgress",
    "Tasks",
    "blocks_centre",
    "compose",
    "contract",
    "free_ahead",
    "geometry",
    "messages",
    "param",
    "run",
    "then",
    "wrap",
]
