"""What must never pass silently: each is a `PriceDataError` that says what, where and the remedy, changing nothing."""

from types import SimpleNamespace

import numpy as np
import pytest
from market_worlds import random_bars

from course_lib.market import (
    CycleMarket,
    DayGridMarket,
    GridEncoder,
    LadderMarket,
    MinMaxEncoder,
    Part,
    PriceDataError,
    RandomWalkMarket,
    ReturnsEncoder,
    RubberBandMarket,
    SideEnv,
    SideVectorEnv,
    TrendMarket,
    WindowEncoder,
    account,
    action_values,
    log_growth,
    optimum,
    oracle,
    percentile,
    random_shifts,
    read_csv,
    real_prices,
    scoreboard,
    split,
    trade,
    walk_forward,
)

NAN, INF = float("nan"), float("inf")
DAY, PLACE = "2020-01-22", 15  # the bar that goes wrong


def world():
    """Good prices, their parts, and what has been fitted and learned on them."""
    prices = random_bars(100)
    parts = split(prices, warmup=5)
    window = WindowEncoder(2).fit(parts.training.close)
    return SimpleNamespace(
        prices=prices, parts=parts, close=prices["close"], window=window, table=np.zeros((18, 3)),
        positions=np.zeros(100, int), q=np.zeros((10, 2, 3)), growth=log_growth(prices),
        env=SideEnv(prices, window, side=1),
    )  # fmt: skip


def everything(w):
    """What a failed call must leave as it is: nothing is sorted, filled or dropped."""
    frames = (w.prices, *(part.prices for part in w.parts))
    return (
        [(frame.to_csv(), [*map(str, frame.dtypes)]) for frame in frames],
        (w.close.tolist(), w.table.tolist(), w.positions.tolist(), w.q.tolist(), w.growth.tolist()),
        dict(vars(w.window)),
    )


class Shows:
    """An encoder that shows what it is told to show, of num_states states."""

    warmup = 0

    def __init__(self, shown, num_states=9):
        self.shown, self.num_states = shown, num_states

    def transform(self, close):
        return self.shown(len(close)) if callable(self.shown) else self.shown


def broken(w, column="close", value=NAN):
    """The prices with one that is wrong, on the day."""
    frame = w.prices.copy()
    if isinstance(value, str):
        frame[column] = frame[column].astype(object)
    frame.iloc[PLACE, frame.columns.get_loc(column)] = value
    return frame


ENCODERS = (
    WindowEncoder, GridEncoder, lambda: GridEncoder(9, "day"),
    MinMaxEncoder, lambda: MinMaxEncoder(None), ReturnsEncoder,
)  # fmt: skip


def side(w, *, encoder=None, prices=None, **given):
    return SideEnv(w.prices if prices is None else prices, encoder or w.window, **({"side": 1} | given))


COSTS = [
    (-0.1, "cost is a fraction of the money a leg, from 0 to 0.2 (0.0005 are 5 basis points), got -0.1"),
    (0.21, "from 0 to 0.2 (0.0005 are 5 basis points), got 0.21"),
    (5, "from 0 to 0.2 (0.0005 are 5 basis points), got 5"),
    (NAN, "cost must be a finite number, got nan"),
    ("cheap", "cost must be a number, got 'cheap'"),
    (None, "cost must be a number, got None"),
]
FILLS = [("open", "fill must be one of close, next_open, next_close, or None, got 'open'"), (1, "got 1")]
CALLS = [
    *((lambda w, cost=cost: side(w, cost=cost), [words]) for cost, words in COSTS),
    *((lambda w, cost=cost: account(w.prices, w.positions, cost=cost), [words]) for cost, words in COSTS),
    *((lambda w, cost=cost: oracle(w.prices, cost=cost), [words]) for cost, words in COSTS),
    *((lambda w, cost=cost: optimum(LadderMarket(), w.prices, cost=cost), [words]) for cost, words in COSTS),
    (lambda _: LadderMarket().mdp(1, -1), ["cost is a fraction of the money a leg", "got -1"]),
    (lambda _: DayGridMarket().mdp(1, 1), ["cost is a fraction of the money a leg", "got 1"]),
    *((lambda w, fill=fill: side(w, fill=fill), [words]) for fill, words in FILLS),
    *((lambda w, fill=fill: log_growth(w.prices, 0, fill), [words]) for fill, words in FILLS),
    (lambda w: side(w, prices=w.prices[["close"]], fill="next_open"),
     ["needs a column open", "use 'close' or 'next_close'"]),
    (lambda w: oracle(w.prices[["close"]], fill="next_open"), ["needs a column open", "use 'close' or 'next_close'"]),
    *(
        (lambda w, door=door, value=value: door(w, value),
         [f"side must be +1 (buy, cash out) or -1 (sell, cash out), got {value!r}"])
        for door in (
            lambda w, value: side(w, side=value),
            lambda w, value: SideVectorEnv(w.prices, w.window, side=value, num_envs=1),
            lambda _, value: LadderMarket().mdp(value),
        )
        for value in (0, 2, "long", None, True, NAN, [1, -1])
    ),
    (lambda w: side(w, episode_length=0), ["episode_length must be from 1 to 97, got 0", "the part has 98 bars"]),
    (lambda w: side(w, episode_length=98), ["episode_length must be from 1 to 97, got 98", "the part has 98 bars"]),
    (lambda w: side(w, prices=w.parts.test, episode_length=20), ["from 1 to 19, got 20", "the part has 20 bars"]),
    (lambda w: side(w, episode_length=2.5), ["episode_length must be a whole number, got 2.5"]),
    (lambda w: side(w, episode_length="all"), ["episode_length must be a whole number, got 'all'"]),
    (lambda w: side(w, reward_unit=0), ["reward_unit must be positive, got 0"]),
    (lambda w: side(w, reward_unit=-1), ["reward_unit must be positive, got -1"]),
    (lambda w: side(w, reward_unit=NAN), ["reward_unit must be a finite number, got nan"]),
    (lambda w: side(w, reward_unit=None), ["reward_unit must be a number, got None"]),
    # Parts
    (lambda w: split(w.prices),
     ["each part needs at least 2 bars", "100 rows, 60 of them warm-up", "[0, 20, 20]", "longer"]),
    (lambda w: split(w.prices, warmup=59), ["100 rows, 59 of them warm-up, give parts of [1, 20, 20]"]),
    (lambda w: split(w.prices, (0.5, 0.5), warmup=5),
     ["shares must be three positive numbers that sum to 1, got (0.5, 0.5)"]),
    (lambda w: split(w.prices, (0.6, 0.2, 0.1), warmup=5), ["numbers that sum to 1, got (0.6, 0.2, 0.1)"]),
    (lambda w: split(w.prices, (0.6, 0.3, 0.2), warmup=5),
     ["three positive numbers that sum to 1, got (0.6, 0.3, 0.2)"]),
    (lambda w: split(w.prices, (1.2, -0.4, 0.2), warmup=5),
     ["three positive numbers that sum to 1, got (1.2, -0.4, 0.2)"]),
    (lambda w: split(w.prices, (0.8, 0.0, 0.2), warmup=5),
     ["three positive numbers that sum to 1, got (0.8, 0.0, 0.2)"]),
    (lambda w: split(w.prices, (0.6, 0.2, NAN), warmup=5), ["a share must be a finite number, got nan"]),
    (lambda w: split(w.prices, "most", warmup=5), ["a share must be a number, got 'm'"]),
    (lambda w: split(w.prices, 0.6, warmup=5), ["shares must be three numbers such as (0.6, 0.2, 0.2), got 0.6"]),
    (lambda w: split(w.prices, warmup=-1), ["warmup must be at least 0, got -1"]),
    (lambda w: split(w.prices, warmup=2.5), ["warmup must be a whole number, got 2.5"]),
    (lambda w: walk_forward(w.prices, 60, 20), ["140 rows of prices are needed, 100 are given"]),
    (lambda w: walk_forward(w.prices, 1, 20), ["training must be at least 2, got 1"]),
    (lambda w: walk_forward(w.prices, 20, 0), ["test must be at least 2, got 0"]),
    (lambda w: walk_forward(w.prices, 20, 5.0), ["test must be a whole number, got 5.0"]),
    (lambda w: walk_forward(w.prices, 20, 10, warmup=-1), ["warmup must be at least 0, got -1"]),
    # Encoders
    *(
        (lambda w, make=make: make().transform(w.close),
         [f"the {type(make()).__name__} is not fitted yet", "call fit(close)"])
        for make in ENCODERS
    ),
    *((lambda w, make=make: side(w, encoder=make()),
     ["is not fitted yet", "training closes first"]) for make in ENCODERS),
    (lambda w: action_values(w.table, w.prices, WindowEncoder(2)), ["the WindowEncoder is not fitted yet"]),
    (lambda w: side(w, prices=w.parts.test, encoder=WindowEncoder(2).fit(w.close)),
     ["the WindowEncoder was fitted on closes up to 2020-05-19", "test part begins on 2020-04-22", "fit(parts."]),
    (lambda w: side(w, prices=w.parts.training, encoder=MinMaxEncoder(5).fit(w.close)),
     ["the MinMaxEncoder was fitted on closes up to 2020-05-19", "training part ends on 2020-03-24", "part alone"]),
    (lambda w: side(w, prices=w.parts.training, encoder=MinMaxEncoder(20).fit(w.close[:60])),
     ["on 2020-01-08 nothing is seen (state -1)", "MinMaxEncoder needs 19 bars", "not 5", "split(prices, warmup=19)"]),
    (lambda w: action_values(w.table, w.parts.training, ReturnsEncoder(8).fit(w.close[:60])),
     ["on 2020-01-08 nothing is seen", "ReturnsEncoder needs 8 bars", "split(prices, warmup=8)"]),
    (lambda w: side(w, encoder=Shows(lambda n: np.arange(n) % 9 - (np.arange(n) == PLACE) * 9)),
     [f"on {DAY} nothing is seen"]),
    (lambda w: side(w, encoder=MinMaxEncoder(200).fit(np.arange(1.0, 300))),
     ["201 rows of prices are needed, 100 are given"]),
    (lambda w: side(w, encoder=Shows(np.arange)), ["states of Shows must be below 9, got 99"]),
    (lambda w: side(w, encoder=Shows(lambda n: np.full((n, 2), -1))), ["one whole number a bar", "[100, 2]"]),
    (lambda w: side(w, encoder=Shows(np.zeros)), ["must show one whole number a bar, the state, got float64"]),
    (lambda w: side(w, encoder=Shows(lambda n: ["up"] * n)), ["must show one whole number a bar, the state, got <U2"]),
    (lambda w: side(w, encoder=Shows(lambda n: ["up"] * n, None)), ["Shows must show numbers, got <U2[100]"]),
    (lambda w: side(w, encoder=Shows(lambda n: np.full((n, 2), INF), None)), ["on 2020-01-01 nothing is seen"]),
    (lambda w: side(w, encoder=Shows(lambda n: np.zeros(n - 1, int))),
     ["must show something at each of 100 bars, got (99,)"]),
    *(
        (lambda w, given=given: SideEnv(w.prices, given, side=1),
         ["an encoder has fit, transform, num_states and warmup, such as MinMaxEncoder(), got"])
        for given in (None, WindowEncoder, "window", 8)
    ),
    (lambda w: action_values(w.table, w.prices, MinMaxEncoder), ["an encoder has fit, transform"]),
    (lambda w: side(w, encoder=Shows(None)), ["must show something at each of 100 bars, got ()"]),
    *((lambda w, make=make: make().fit(w.close[:1]),
     ["closes are needed, 1 are given: take a longer stretch"]) for make in ENCODERS),
    (lambda w: WindowEncoder(8).fit(w.close[:8]), ["9 closes are needed, 8 are given"]),
    (lambda w: w.window.fit(broken(w)["close"]),
     ["closes must be positive and finite, got nan", f"on {DAY}", "correct it"]),
    (lambda w: w.window.transform(broken(w, value=-1.0)["close"]),
     ["must be positive and finite, got -1.0", f"on {DAY}"]),
    (lambda w: w.window.transform([1, 2, 0]), ["closes must be positive and finite, got 0.0 in place 2"]),
    (lambda w: w.window.fit(broken(w, value="much")["close"]), ["closes must be numbers: use pandas.to_numeric"]),
    (lambda w: w.window.fit(w.prices), ["closes must be one column of numbers, got shape (100, 5)"]),
    (lambda w: w.window.fit(w.parts.training), ["closes must be numbers"]),
    (lambda w: w.window.transform([]), ["1 closes are needed, 0 are given"]),
    (lambda _: ReturnsEncoder().fit(np.full(50, 3.0)), ["the closes never move in training"]),
    (lambda _: GridEncoder(9, "day").fit(np.full(50, 3.0)), ["no price moves within a day: is each bar a day?"]),
    (lambda _: WindowEncoder(0), ["k must be from 1 to 16, got 0"]),
    (lambda _: WindowEncoder(17), ["k must be from 1 to 16, got 17"]),
    (lambda _: WindowEncoder(flat=-0.1), ["flat must not be negative, got -0.1"]),
    (lambda _: WindowEncoder(flat="half"), ["flat must be a number, got 'half'"]),
    (lambda _: GridEncoder(1), ["n must be from 2 to 1000, got 1"]),
    (lambda _: GridEncoder(8, mode="week"), ["mode must be 'turn' or 'day', got 'week'"]),
    (lambda _: MinMaxEncoder(1), ["m must be from 2 to 100000, got 1"]),
    (lambda _: MinMaxEncoder(levels=1), ["levels must be from 2 to 10000, got 1"]),
    (lambda _: ReturnsEncoder(0), ["k must be from 1 to 10000, got 0"]),
    (lambda _: ReturnsEncoder(clip=-1), ["clip must not be negative, got -1"]),
    # Positions and action values
    *(
        (lambda w, door=door, value=value: door(w, value), [words])
        for door in (
            lambda w, value: account(w.prices, value), lambda w, value: percentile(w.prices, value),
            lambda w, value: scoreboard(w.prices, {"ours": value}),
        )
        for value, words in (
            (np.zeros(99, int), "positions must be whole numbers, one for each of 100 bars, got int64[99]"),
            (np.zeros((100, 3), int), "one for each of 100 bars, got int64[100, 3]"),
            (np.zeros(100), "positions must be whole numbers, one for each of 100 bars, got float64[100]"),
            (np.zeros(100, bool), "got bool[100]"), (0, "got int64[]"), (None, "got object[]"),
            ([[0], [0, 1]], "several lengths"),
            (np.full(100, 2), "positions must be -1, 0 or 1, got 2 to 2"), (np.arange(100) - 99, "got -99 to 0"),
        )
    ),
    (lambda w: account(w.prices, w.positions, growth=w.growth[:50]),
     ["log_growth of the part's own bars, [99, 3, 3], got [50, 3, 3]"]),
    (lambda _: random_shifts(np.zeros((2, 9), int)),
     ["positions must be those of one trader, int[N], got shape (2, 9)"]),
    (lambda _: random_shifts([1]), ["positions must be those of one trader"]),
    (lambda _: random_shifts(3), ["positions must be whole numbers"]),
    (lambda _: random_shifts([0.5, 1.0]), ["positions must be whole numbers, one a bar, got float64[2]"]),
    (lambda w: percentile(w.prices, np.zeros((2, 100), int)), ["positions must be those of one trader"]),
    *(
        (lambda w, value=value: oracle(w.prices, sides=value),
         [f"sides must be (1,), (-1,) or both, (-1, 1), got {value!r}"])
        for value in ((), (2,), (0, 1), 1, "both", None)
    ),
    (lambda w: trade(w.q, w.q[:9]), ["action values must have one shape, […, N, 2, 3], got [(9, 2, 3), (10, 2, 3)]"]),
    (lambda w: trade(w.q[:, 0]), ["action values must have one shape, […, N, 2, 3], got [(10, 3)]"]),
    (lambda w: trade(w.q[0]), ["[…, N, 2, 3], got [(2, 3)]"]),
    (lambda _: trade(), ["action values must have one shape"]),
    (lambda w: trade(np.where(w.q == 0, NAN, 1)), ["action values must be numbers, 60 of 60 are NaN"]),
    (lambda w: trade("long", w.q), ["action values must be an array of numbers, got str"]),
    (lambda _: trade([[1, 2], [3]]), ["action values must be an array of numbers, got list"]),
    (lambda w: action_values(np.zeros((9, 3)), w.prices, w.window), ["has 18 rows and 3 columns, got (9, 3)"]),
    (lambda w: action_values(np.full((18, 3), NAN), w.prices, w.window), ["a table must be numbers, 54 of 54 are NaN"]),
    (lambda w: action_values(None, w.prices, w.window), ["a table must be numbers, 1 of 1 are NaN"]),
    (lambda w: action_values(w.env, w.prices, w.window), ["a table must be an array of numbers, got SideEnv"]),
    (lambda w: scoreboard(w.prices, w.positions), ["traders must be a dictionary, {name: positions}, got ndarray"]),
    (lambda w: Part("train", w.prices, 5), ["a part is called training, validation or test, got 'train'"]),
    (lambda w: Part("test", w.prices, 99), ["first must be from 0 to 98, got 99", "100 bars", "a part needs 2"]),
    (lambda w: Part("test", w.prices, -1), ["first must be from 0 to 98, got -1"]),
    (lambda w: Part("test", w.prices, 2.0), ["first must be a whole number, got 2.0"]),
    (lambda w: Part("test", w.prices.iloc[:0], 1), ["there are 0 bars"]),
    # Shares, files, markets
    (lambda w: optimum("IBM", w.prices), ["only of a made-up market, such as LadderMarket()", "got 'IBM'"]),
    (lambda _: real_prices("TSLA"), ["there are prices of AAPL, GOOG, IBM, MSFT, got 'TSLA'"]),
    (lambda _: real_prices("ibm"), ["AAPL, GOOG, IBM, MSFT, got 'ibm'"]),
    (lambda _: real_prices(None), ["AAPL, GOOG, IBM, MSFT, got None"]),
    (lambda _: read_csv("no/such/file.csv"),
     ["no/such/file.csv is no file of comma-separated values that can be read"]),
    (lambda _: LadderMarket().prices(1), ["num_bars must be at least 2, got 1"]),
    (lambda _: DayGridMarket().prices(2.5), ["num_bars must be a whole number, got 2.5"]),
    (lambda _: RubberBandMarket(kappa=0), ["kappa must be above 0 and at most 1, got 0"]),
    (lambda _: RubberBandMarket(kappa=1.1), ["kappa must be above 0 and at most 1, got 1.1"]),
    (lambda _: RubberBandMarket(sigma=NAN), ["sigma must be a finite number, got nan"]),
    (lambda _: TrendMarket(stay=1.5), ["stay must be above 0 and at most 1, got 1.5"]),
    (lambda _: TrendMarket(drift=-0.1), ["drift must be above 0 and at most 0.1, got -0.1"]),
    (lambda _: TrendMarket(sigma=0), ["sigma must be above 0 and at most 0.2, got 0"]),
    (lambda _: CycleMarket(period=1), ["period must be at least 2, got 1"]),
    (lambda _: CycleMarket(amplitude=2), ["amplitude must be above 0 and at most 1, got 2"]),
    (lambda _: RandomWalkMarket(sigma="wild"), ["sigma must be a number, got 'wild'"]),
]  # fmt: skip


def named(table):
    return [f"{i:03} {words[0]}" for i, (_, words) in enumerate(table)]


def assert_refused(call, words):
    w = world()
    before = everything(w)
    with pytest.raises(PriceDataError, match=r"^[^\n]+$") as error:
        call(w)
    assert all(word in str(error.value) for word in words), str(error.value)
    assert everything(w) == before
    assert isinstance(error.value, ValueError)


@pytest.mark.filterwarnings("ignore:split or crash")
@pytest.mark.parametrize(("call", "words"), CALLS, ids=named(CALLS))
def test_bad_input_is_refused_in_one_clear_sentence_and_changes_nothing(call, words):
    assert_refused(call, words)
