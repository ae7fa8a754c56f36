"""Which bars may be learned from, and which are kept unseen."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from course_lib.market.prices import PriceDataError, as_price_errors, check_prices
from course_lib.validate import number, whole_number


@dataclass(frozen=True, eq=False)
class Part:
    """A stretch of a price history in which one trades, and the bars before it, which one may look at.

    name     "training", "validation" or "test"
    prices   DataFrame: all bars up to the end of the part, the earlier ones included
    first    number of the first bar of the part, the earlier bars being the warm-up of what an agent sees

    `PriceDataError` for another name, and where fewer than 2 bars are left to trade.
    """

    name: str
    prices: pd.DataFrame
    first: int

    def __post_init__(self):
        if self.name not in ("training", "validation", "test"):
            raise PriceDataError(f"a part is called training, validation or test, got {self.name!r}")
        with as_price_errors(f"; there are {len(self.prices)} bars, and a part needs 2"):
            whole_number("first", self.first, below=max(len(self.prices) - 1, 1))

    @property
    def close(self):
        """The closes of the part itself, a Series: what an encoder may be fitted on if this is the training part."""
        return self.prices["close"].iloc[self.first :]

    @property
    def dates(self):
        """The dates of the part itself."""
        return self.prices.index[self.first :]

    def __len__(self):
        return len(self.prices) - self.first

    def __repr__(self):
        return f"<{self.name}: {len(self)} bars, {self.dates[0]:%Y-%m-%d} to {self.dates[-1]:%Y-%m-%d}>"

    def check_fitted(self, encoder):
        """`PriceDataError` if the encoder was fitted on what it must not know: days of an unseen part, or later."""
        until = getattr(encoder, "fitted_until", None)
        if until is None:
            return
        if self.name == "training" and until > self.dates[-1]:
            raise PriceDataError(
                f"the {type(encoder).__name__} was fitted on closes up to {until:%Y-%m-%d}, but the training part "
                f"ends on {self.dates[-1]:%Y-%m-%d}: fit it on the training part alone, fit(parts.training.close)"
            )
        if self.name != "training" and until >= self.dates[0]:
            raise PriceDataError(
                f"the {type(encoder).__name__} was fitted on closes up to {until:%Y-%m-%d}, but the {self.name} part "
                f"begins on {self.dates[0]:%Y-%m-%d}: fit it on the training part alone, fit(parts.training.close)"
            )


@dataclass(frozen=True, eq=False)
class Split:
    """Three `Part`s, one after the other in time."""

    training: Part
    validation: Part
    test: Part

    def __iter__(self):
        return iter((self.training, self.validation, self.test))


def split(prices, shares=(0.6, 0.2, 0.2), *, warmup=60):
    """`Split` of the prices by time, never shuffled: the oldest bars to learn from, the latest kept for the end.

    shares  three positive numbers that sum to 1: of training, validation and test
    warmup  bars at the very beginning that are only looked at: as many as the encoder needs that needs most

    `PriceDataError` for other shares, and for too few rows: each part needs 2 bars to trade.
    """
    try:
        shares = [number("a share", share) for share in shares]
    except TypeError:
        raise PriceDataError(f"shares must be three numbers such as (0.6, 0.2, 0.2), got {shares!r}") from None
    except ValueError as error:
        raise PriceDataError(str(error)) from None
    if len(shares) != 3 or min(shares) <= 0 or abs(sum(shares) - 1) > 1e-9:
        raise PriceDataError(f"shares must be three positive numbers that sum to 1, got {tuple(shares)}")
    warmup = _bars("warmup", warmup, at_least=0)
    prices = check_prices(prices)
    ends = [round(len(prices) * sum(shares[: i + 1])) for i in range(3)]
    bars = np.diff([warmup, *ends])
    if bars.min() < 2:
        raise PriceDataError(
            f"each part needs at least 2 bars, but {len(prices)} rows, {warmup} of them warm-up, give parts of "
            f"{bars.tolist()}: take a longer stretch"
        )
    return Split(
        Part("training", prices.iloc[: ends[0]], warmup),
        Part("validation", prices.iloc[: ends[1]], ends[0]),
        Part("test", prices, ends[1]),
    )


def walk_forward(prices, training, test, *, warmup=60):
    """[(training `Part`, test `Part`), …]: learn on so many bars, trade the next ones unseen, move on and begin again.

    training, test, warmup  numbers of bars; the test parts follow one another without gap. `PriceDataError` for too
                            few rows
    """
    training, test = (_bars(name, bars) for name, bars in (("training", training), ("test", test)))
    warmup = _bars("warmup", warmup, at_least=0)
    prices = check_prices(prices, at_least=warmup + training + test)
    return [
        (
            Part("training", prices.iloc[:begins], begins - training),
            Part("test", prices.iloc[: begins + test], begins),
        )
        for begins in range(warmup + training, len(prices) - test + 1, test)
    ]


def _bars(name, value, at_least=2):
    with as_price_errors():
        return whole_number(name, value, at_least=at_least)


def as_part(prices, encoder=None, name="training"):
    """`prices` if they are a `Part`; a whole frame of prices becomes one, whose first bars warm the encoder up."""
    if isinstance(prices, Part):
        return prices
    first = getattr(encoder, "warmup", 0)
    return Part(name, check_prices(prices, at_least=first + 2), first)
