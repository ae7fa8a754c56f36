"""The second world of the course: prices, what an agent sees of them, trading with its costs, and honest yardsticks."""

from course_lib.market.accounting import Account, account, log_growth
from course_lib.market.luck import coin_tossers
from course_lib.market.optimum import optimum
from course_lib.market.parts import Part, Split, split, walk_forward
from course_lib.market.prices import PriceDataError, check_prices, read_csv, real_prices
from course_lib.market.side import SideEnv
from course_lib.market.side_vector import SideVectorEnv
from course_lib.market.states import GridEncoder, MinMaxEncoder, ReturnsEncoder, WindowEncoder
from course_lib.market.synthetic import (
    CycleMarket,
    DayGridMarket,
    LadderMarket,
    RandomWalkMarket,
    RubberBandMarket,
    TrendMarket,
)
from course_lib.market.trader import action_values, trade
from course_lib.market.yardsticks import (
    Metrics,
    buy_and_hold,
    flat,
    metrics,
    oracle,
    percentile,
    random_shifts,
    scoreboard,
)

__all__ = [
    "Account",
    "CycleMarket",
    "DayGridMarket",
    "GridEncoder",
    "LadderMarket",
    "Metrics",
    "MinMaxEncoder",
    "Part",
    "PriceDataError",
    "RandomWalkMarket",
    "ReturnsEncoder",
    "RubberBandMarket",
    "SideEnv",
    "SideVectorEnv",
    "Split",
    "TrendMarket",
    "WindowEncoder",
    "account",
    "action_values",
    "buy_and_hold",
    "check_prices",
    "coin_tossers",
    "flat",
    "log_growth",
    "metrics",
    "optimum",
    "oracle",
    "percentile",
    "random_shifts",
    "read_csv",
    "real_prices",
    "scoreboard",
    "split",
    "trade",
    "walk_forward",
]
