"""Learn with a network: deep Q-learning for one agent or for many side by side (Mnih et al., 2015)."""

from course_lib.dqn.agent import DQNAgent

__all__ = ["DQNAgent"]
