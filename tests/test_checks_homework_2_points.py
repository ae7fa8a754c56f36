"""What a mistake costs in homework 2: the points of the trials that are about it, and no others."""

import runpy
from pathlib import Path

import pytest

from course_lib.checks import homework_2
from course_lib.checks.verdict import Outcome

WRONG = Path(__file__).with_name("answers") / "homework_2" / "wrong"
# 1 for each trial that is passed all the same.
PASSED = {
    "standing_still_is_no_flat_move": "11011",
    "threshold_of_all_moves": "11100",
    "threshold_of_one_move_more": "11101",
    "digits_reversed": "00001",
    "middle_row_as_upper_half": "10001",
    "first_of_equal_extremes": "11001",
    "standing_still_divides_by_zero": "11101",
    "nan_becomes_a_row": "11101",
    "low_and_high_of_all": "00000",
    "standing_still_is_level_zero": "11101",
    "level_zero_at_the_high": "00001",
    "short_as_long": "0000",
    "old_position_pays": "1000",
    "opening_bar_pays_nothing": "1000",
    "fee_forgotten": "1100",
    "fee_only_to_open": "1100",
    "cost_off_the_gain": "1100",
    "alpha_forgotten": "0001",
    "gamma_forgotten": "0001",
    "no_bootstrap": "1000",
    "mean_of_the_next_row": "1000",
    "max_over_impossible_actions": "1101",
    "impossible_counts_as_zero": "1000",
    "possible_actions_exchanged": "1000",
    "holds_only": "1000",
    "row_of_pairs": "0000",
    "compares_q_of_open": "000001",
    "long_table_closes": "100001",
    "never_closes": "100001",
    "never_turns_round": "110111",
    "reopens_in_the_same_bar": "110111",
    "turns_round_at_any_price": "110101",  # also where both sides gain the same
    "turns_round_at_equals": "111101",
    "trades_the_warm_up": "111011",
    "opens_at_a_tie": "111101",
    "opens_at_zero": "111101",
    "long_opens_of_equals": "111101",
    "short_opens_of_equals": "111101",
    "first_opens_of_equals": "111101",
    "closes_at_a_tie": "111101",
    "knows_the_next_state": "000000",
    "change_too_small": "0000",
    "shuffles_the_future": "1101",
    "one_close_at_a_time": "1101",
    "near_the_change_only": "1001",
    "changes_close_itself": "0000",
    "loses_the_old_closes": "0000",
    "always_true": "0000",
    "always_false": "0000",
}


@pytest.mark.filterwarnings("ignore:.*encountered in:RuntimeWarning")  # some of them divide by zero
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("name", "passed"), PASSED.items(), ids=PASSED)
def test_a_mistake_costs_the_points_of_its_trials(name, passed, seed):
    answer = runpy.run_path(str(WRONG / f"{name}.py"))
    check = getattr(homework_2, answer["CHECK"])
    verdict = check(answer[check.usage.split("(")[0]], seed=seed)
    assert "".join(str(int(row.outcome is Outcome.PASSED)) for row in verdict.rows) == passed
    assert verdict.points == passed.count("1")
