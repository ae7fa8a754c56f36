"""Prices that cannot be traded are refused by everything that takes prices, and left as they are."""

import pytest
from test_market_bad_input import DAY, INF, NAN, PLACE, broken, named, world

from course_lib.market import (
    LadderMarket,
    PriceDataError,
    SideEnv,
    SideVectorEnv,
    account,
    action_values,
    buy_and_hold,
    check_prices,
    flat,
    log_growth,
    optimum,
    oracle,
    percentile,
    scoreboard,
    split,
    walk_forward,
)


def swapped(frame):
    """Two days that have changed places."""
    return frame.iloc[[*range(PLACE), PLACE + 1, PLACE, *range(PLACE + 2, len(frame))]]


def twice(frame):
    return frame.iloc[[*range(PLACE + 1), *range(PLACE, len(frame))]]


FRAMES = [  # what is done to the prices, and what is said of them
    (lambda w: w.prices.drop(columns="close"),
     ["column close is missing", "there are: open, high, low, volume", "add it"]),
    (lambda w: w.prices.drop(columns=["open", "low"]),
     ["column open and low is missing", "there are: close, high, volume"]),
    (lambda w: w.prices[["close", "high", "low", "open"]],
     ["column volume is missing", "close, high, low, open", "Rename"]),
    (lambda w: w.prices.rename(columns=str.title),
     ["column close is missing; there are: Close, Open, High, Low, Volume"]),
    (lambda w: w.prices[[]], ["column close is missing; there are: none"]),
    (lambda w: w.prices[["close", "close"]], ["every column must be there once, got close, close"]),
    (lambda w: w.prices.set_axis([[*w.prices], ["IBM"] * 5], axis=1), ["one name each, got ('close', 'IBM')"]),
    (lambda w: w.prices.reset_index(drop=True),
     ["index must hold dates", "got RangeIndex of int64", "set_index('date')"]),
    (lambda w: w.prices.set_axis([f"{d:%Y-%m-%d}" for d in w.prices.index]), ["must hold dates", "to_datetime"]),
    (lambda w: swapped(w.prices), ["dates must increase", f"{DAY} comes after 2020-01-23", "frame.sort_index()"]),
    (lambda w: w.prices[::-1], ["dates must increase", "2020-05-18 comes after 2020-05-19", "frame.sort_index()"]),
    (lambda w: twice(w.prices), [f"the date {DAY} is there twice", "keep one"]),
    (lambda w: w.prices.set_axis(w.prices.index.where(w.prices.index != DAY)), [f"no date in row {PLACE}", "remove"]),
    (lambda w: broken(w, value="a lot"),
     ["column 'close' must hold numbers", f"'a lot' on {DAY}", "pandas.to_numeric"]),
    (lambda w: w.prices.astype({"low": str}), ["column 'low' must hold numbers", "on 2020-01-01", "pandas.to_numeric"]),
    (lambda w: w.prices.assign(volume=True), ["column 'volume' must hold numbers, got bool"]),
    *(
        (lambda w, column=column, value=value: broken(w, column, value),
         [f"column {column!r} holds {words} on {DAY}", "correct it"])
        for value, words in ((NAN, "NaN"), (INF, "infinity"), (0.0, "zero"), (-1.0, "a negative number"))
        for column in ("open", "high", "low", "close", "volume") if (column, value) != ("volume", 0)
    ),
    (lambda w: broken(w, "high", 1.0), [f"high is below low on {DAY}", "exchange or correct them"]),
    (lambda w: broken(w, "low", w.prices["high"].iloc[PLACE] * 1.001), [f"high is below low on {DAY}"]),
    (lambda w: broken(w, "open", 1.0),
     ["column 'open' is outside low and high", f"on {DAY}", "correct one of the three"]),
    (lambda w: broken(w, "close", 1e3),
     ["column 'close' is outside low and high", f"on {DAY}", "correct one of the three"]),
    (lambda w: w.prices.iloc[:1], ["rows of prices are needed, 1 are given", "take a longer stretch"]),
    (lambda w: w.prices.iloc[:0], ["rows of prices are needed, 0 are given"]),
    (lambda w: w.close, ["prices must be a pandas DataFrame, got Series"]),
    (lambda w: w.prices.to_numpy(), ["prices must be a pandas DataFrame, got ndarray"]),
    (lambda _: None, ["prices must be a pandas DataFrame, got NoneType"]),
]  # fmt: skip
DOORS = {  # every function that takes prices
    "check_prices": lambda _, frame: check_prices(frame),
    "SideEnv": lambda w, frame: SideEnv(frame, w.window, side=1),
    "SideVectorEnv": lambda w, frame: SideVectorEnv(frame, w.window, side=1, num_envs=2),
    "account": lambda w, frame: account(frame, w.positions),
    "action_values": lambda w, frame: action_values(w.table, frame, w.window),
    "buy_and_hold": lambda _, frame: buy_and_hold(frame),
    "flat": lambda _, frame: flat(frame),
    "log_growth": lambda _, frame: log_growth(frame),
    "optimum": lambda _, frame: optimum(LadderMarket(), frame),
    "oracle": lambda _, frame: oracle(frame),
    "percentile": lambda w, frame: percentile(frame, w.positions),
    "scoreboard": lambda w, frame: scoreboard(frame, {"flat": w.positions}),
    "split": lambda _, frame: split(frame, warmup=2),
    "walk_forward": lambda _, frame: walk_forward(frame, 20, 10, warmup=2),
}


@pytest.mark.filterwarnings("ignore:split or crash")
@pytest.mark.parametrize(("spoil", "words"), FRAMES, ids=named(FRAMES))
def test_bad_prices_are_refused_at_every_door_and_left_as_they_are(spoil, words):
    w = world()
    frame = spoil(w)
    before = frame.to_csv() if hasattr(frame, "to_csv") else repr(frame)
    for name, door in DOORS.items():
        with pytest.raises(PriceDataError, match=r"^[^\n]+$") as error:
            door(w, frame)
        assert all(word in str(error.value) for word in words), (name, str(error.value))
        assert (frame.to_csv() if hasattr(frame, "to_csv") else repr(frame)) == before, "nothing is mended"
