"""Services of a zeronav stack in Python: the contract, and the loop that every service shares."""

from . import contract, geometry, messages
from .controller import Controller, Scene
from .geometry import compose, free_ahead, then, wrap
from .inputs import CurrentGoal, MapInput, OdometryReader, Tasks
from .outputs import PathOutput, TaskProgress
from .parameters import param
from .planner import Planner, blocks_centre
from .service import NoConfig, Service, run
from .shell import IDLE, Due, Shell

__all__ = [
    "IDLE",
    "Controller",
    "CurrentGoal",
    "Due",
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
