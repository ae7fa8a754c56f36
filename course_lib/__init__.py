"""Reinforcement learning from a maze to markets: the small package behind the notebooks.

Everything a lesson uses is importable from here, and nothing is loaded before it is used:
`import course_lib` costs the import of Gymnasium, no compiler, no torch, no plotting.
"""

from importlib import import_module

import gymnasium

__version__ = "0.1.0"

_HOME_OF = {
    "Action": "maze",
    "LESSON_GRID": "maze",
    "Maze": "maze",
    "Tile": "maze",
    "MDP": "mdp",
    "Solution": "bellman",
    "action_values": "bellman",
    "bellman_sweep": "bellman",
    "evaluate_policy": "bellman",
    "policy_iteration": "bellman",
    "value_iteration": "bellman",
    "DQNAgent": "dqn",
    "QAgent": "q_table",
    "History": "history",
    "Rollout": "history",
}
_MODULES = ("bellman", "dqn", "explore", "history", "market", "maze", "mdp", "plots", "q_table", "study")

__all__ = sorted([*_HOME_OF, *_MODULES])


def __getattr__(name):
    """Load the module that holds `name` at the first use of it (PEP 562)."""
    if name in _HOME_OF:
        value = getattr(import_module(f"course_lib.{_HOME_OF[name]}"), name)
    elif name in _MODULES:
        value = import_module(f"course_lib.{name}")
    else:
        raise AttributeError(f"course_lib has no {name!r}; it has: {', '.join(__all__)}")
    globals()[name] = value
    return value


def __dir__():
    return __all__


gymnasium.register(
    id="course_lib/Maze-v0",
    entry_point="course_lib.maze:Maze",
    max_episode_steps=1000,
)
gymnasium.register(id="course_lib/Side-v0", entry_point="course_lib.market:SideEnv")
