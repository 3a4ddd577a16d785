"""Services of a zeronav stack in Python: the contract, and the loop that every service shares."""

from . import contract, messages
from .inputs import CurrentGoal, MapInput, OdometryReader, Tasks, compose, then, wrap
from .outputs import PathOutput, TaskProgress
from .parameters import param
from .service import NoConfig, Service, run
from .shell import IDLE, Due, Shell

__all__ = [
    "IDLE",
    "CurrentGoal",
    "Due",
    "MapInput",
    "NoConfig",
    "OdometryReader",
    "PathOutput",
    "Service",
    "Shell",
    "TaskProgress",
    "Tasks",
    "compose",
    "contract",
    "messages",
    "param",
    "run",
    "then",
    "wrap",
]
