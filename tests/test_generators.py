"""One generator in place of many: it draws what each of them would."""

import numpy as np
import pytest

from course_lib.generators import OneForMany


def test_each_draws_in_turn_what_it_draws_alone():
    one = OneForMany(3)
    for i in range(3):
        one.keep(i, np.random.default_rng(i))
    rng, state, states = one.parts
    drawn = np.zeros((3, 40))
    for turn in range(4):
        for i in range(3):
            state[:] = states[i]
            drawn[i, 10 * turn : 10 * turn + 10] = rng.random(10)
            states[i] = state
    for i in range(3):
        assert np.array_equal(drawn[i], np.random.default_rng(i).random(40))


def test_another_kind_of_generator_is_refused():
    with pytest.raises(ValueError, match="PCG64"):
        OneForMany(1).keep(0, np.random.Generator(np.random.SFC64(0)))
