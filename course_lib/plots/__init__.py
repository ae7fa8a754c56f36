"""Pictures that stand still. Each function returns a `Picture`, which a notebook shows with its text alternative."""

from course_lib.plots.cart_pole import cart_pole
from course_lib.plots.curves import contraction, counts, learning_curves
from course_lib.plots.diagrams import agent_loop, method_chart, neural_network
from course_lib.plots.grid import action_values, maze, stages, transition, values
from course_lib.plots.market import grid_of_states, in_and_out, trades, wealth
from course_lib.plots.networks import forward_pass, seed_by_seed
from course_lib.plots.picture import Picture
from course_lib.plots.studies import bands, heat_map, intervals

__all__ = [
    "Picture",
    "action_values",
    "agent_loop",
    "bands",
    "cart_pole",
    "contraction",
    "counts",
    "forward_pass",
    "grid_of_states",
    "heat_map",
    "in_and_out",
    "intervals",
    "learning_curves",
    "maze",
    "method_chart",
    "neural_network",
    "seed_by_seed",
    "stages",
    "trades",
    "transition",
    "values",
    "wealth",
]
