"""Prices, real or from a learner's own file, and all that can be wrong with them."""

import warnings
from contextlib import contextmanager

import numpy as np
import pandas as pd

from course_lib.validate import whole_number

COLUMNS = ("open", "high", "low", "close", "volume")
REAL_SHARES = ("AAPL", "GOOG", "IBM", "MSFT")
_LARGE_MOVE = 0.4  # of the log price in one bar: a split that nobody adjusted for, or a crash


class PriceDataError(ValueError):
    """Something about prices, or what is to be done with them, that must not pass: what, where, and the remedy."""


@contextmanager
def as_price_errors(more=""):
    """What `course_lib.validate` refuses in this block is a `PriceDataError`, with `more` after its words."""
    try:
        yield
    except ValueError as error:
        raise PriceDataError(f"{error}{more}") from None


def real_prices(symbol):
    """Daily prices of a real share, 2000 (GOOG: 2004) to 2013: a frame as `check_prices` wants it.

    symbol  AAPL, GOOG, IBM or MSFT

    From the package bokeh_sampledata (public domain; no network). Open, high, low and close are multiplied by
    adj_close / close: the raw prices fall by half where a share was split in two. These four were chosen with
    hindsight, as shares everybody still knows: what holds for them need not hold for a share picked in 2000.
    """
    if symbol not in REAL_SHARES:
        raise PriceDataError(f"there are prices of {', '.join(REAL_SHARES)}, got {symbol!r}")
    from bokeh_sampledata import stocks

    raw = pd.DataFrame(getattr(stocks, symbol))
    raw.index = pd.DatetimeIndex(pd.to_datetime(raw["date"]), name="date")
    return check_prices(adjusted(raw))


def read_csv(path):
    """Daily prices from your own file: a frame as `check_prices` wants it.

    The first column, or one called date, holds the dates (2024-03-15); others are open, high, low, close, volume, in
    any case. With a column adj_close (or "Adj Close") prices are adjusted by it, as `real_prices` says. Nothing is
    sorted, filled or dropped: `PriceDataError` says what is wrong and what to do.
    """
    try:
        raw = pd.read_csv(path)
    except (OSError, TypeError, ValueError) as error:  # every error of pandas's parser is a ValueError
        reason = " ".join(str(error).split())
        raise PriceDataError(f"{path} is no file of comma-separated values that can be read: {reason}") from None
    raw.columns = [str(name).strip().lower().replace(" ", "_") for name in raw.columns]
    _check_once(raw.columns)
    when = "date" if "date" in raw.columns else raw.columns[0]
    try:
        if pd.api.types.is_numeric_dtype(raw[when]):
            raise ValueError("they are numbers")
        dates = pd.to_datetime(raw[when], format="ISO8601")
    except (ValueError, TypeError) as error:
        raise PriceDataError(
            f"column {when!r} of {path} must hold dates such as 2024-03-15 ({str(error).splitlines()[0]})"
        ) from None
    raw.index = pd.DatetimeIndex(dates, name="date")
    frame = raw.drop(columns=when)
    return check_prices(adjusted(frame) if "adj_close" in frame else frame)


def adjusted(raw):
    """The price columns of `raw` multiplied by adj_close / close, so that splits and dividends move nothing."""
    names = [name for name in COLUMNS if name in raw.columns]
    if "close" not in names:
        raise PriceDataError(_missing(raw, ["close"]))
    _check_dates(raw.index)
    _check_rows(raw, 2)
    for name in [*names, "adj_close"]:
        _check_numbers(raw[name], name)
    factor = raw["adj_close"] / raw["close"]
    frame = raw[names].astype(float)
    for name in set(names) - {"volume"}:
        frame[name] = frame[name] * factor
    return frame


def check_prices(prices, *, at_least=2):
    """`prices` itself if it can be traded; otherwise a `PriceDataError` with column, first bad date and remedy.

    A frame with increasing dates as index and the columns open, high, low, close and volume; or close alone, as of the
    synthetic markets. Prices are positive, and low <= open, close <= high. A move by more than 0.4 of the log price in
    one bar is warned of, since it may be a split or a crash, and kept.

    at_least  rows that are needed
    """
    if not isinstance(prices, pd.DataFrame):
        raise PriceDataError(f"prices must be a pandas DataFrame, got {type(prices).__name__}")
    _check_once(prices.columns)
    wanted = ["close"] if not {"open", "high", "low"} & set(prices.columns) else COLUMNS
    missing = [name for name in wanted if name not in prices.columns]
    if missing:
        raise PriceDataError(_missing(prices, missing))
    _check_dates(prices.index)
    _check_rows(prices, whole_number("at_least", at_least))
    for name in wanted:
        _check_numbers(prices[name], name)
    if "open" in wanted:
        _check_bars(prices)
    _warn_of_large_moves(prices["close"])
    return prices


def _missing(prices, missing):
    have = ", ".join(map(str, prices.columns)) or "none"
    return f"column {' and '.join(missing)} is missing; there are: {have}. Rename or add it"


def _check_once(columns):
    if columns.nlevels > 1:
        raise PriceDataError(f"columns must have one name each, got {columns[0]}: use frame.droplevel(1, axis=1)")
    if not columns.is_unique:
        raise PriceDataError(f"every column must be there once, got {', '.join(map(str, columns))}")


def _check_rows(prices, at_least):
    if len(prices) < at_least:
        raise PriceDataError(f"{at_least} rows of prices are needed, {len(prices)} are given: take a longer stretch")


def _check_dates(index):
    if not isinstance(index, pd.DatetimeIndex):
        raise PriceDataError(
            f"the index must hold dates (a DatetimeIndex), got {type(index).__name__} of {index.dtype}: "
            "use frame.set_index('date') after pandas.to_datetime"
        )
    if index.hasnans:
        place = int(np.flatnonzero(index.isna())[0])
        raise PriceDataError(f"the index has no date in row {place}: remove the row or give it its date")
    if index.has_duplicates:
        raise PriceDataError(f"the date {_day(index[index.duplicated()][0])} is there twice: keep one of its rows")
    if not index.is_monotonic_increasing:
        place = int(np.flatnonzero(np.diff(index.asi8) < 0)[0]) + 1
        raise PriceDataError(
            f"the dates must increase, but {_day(index[place])} comes after {_day(index[place - 1])}: "
            "use frame.sort_index()"
        )


def _check_numbers(column, name):
    """Finite and, but for the volume, positive."""
    if column.dtype.kind not in "iuf":
        is_text = pd.to_numeric(column.astype(str), errors="coerce").isna().to_numpy()  # or all are numbers as text
        place = int(np.argmax(is_text))
        raise PriceDataError(
            f"column {name!r} must hold numbers, got {column.dtype} ({str(column.iloc[place])!r} on "
            f"{_day(column.index[place])}): use pandas.to_numeric"
        )
    values = column.to_numpy(dtype=float, na_value=np.nan)
    for is_bad, what in (
        (np.isnan(values), "NaN"),
        (np.isinf(values), "infinity"),
        (values < 0, "a negative number"),
        ((values == 0) & (name != "volume"), "zero"),
    ):
        if is_bad.any():
            date = column.index[int(np.argmax(is_bad))]
            raise PriceDataError(
                f"column {name!r} holds {what} on {_day(date)}: correct it, or leave that bar out knowingly"
            )


def _check_bars(prices):
    """Whether low <= open, close <= high; rounding by the last digits of a float passes."""
    low, high = (prices[name].to_numpy(float) for name in ("low", "high"))
    _refuse_first(prices, high < low * (1 - 1e-9), "high is below low", "exchange or correct them")
    for name in ("open", "close"):
        values = prices[name].to_numpy(float)
        outside = (values < low * (1 - 1e-9)) | (values > high * (1 + 1e-9))
        _refuse_first(prices, outside, f"column {name!r} is outside low and high", "correct one of the three")


def _refuse_first(prices, is_bad, what, remedy):
    if is_bad.any():
        raise PriceDataError(f"{what} on {_day(prices.index[int(np.argmax(is_bad))])}: {remedy}")


def _warn_of_large_moves(close):
    moves = np.diff(np.log(close.to_numpy(float)))
    large = np.flatnonzero(np.abs(moves) > _LARGE_MOVE)
    if len(large):
        date, more = close.index[large[0] + 1], f" (and {len(large) - 1} more)" if len(large) > 1 else ""
        message = (
            f"split or crash? On {_day(date)} the close went to {np.exp(moves[large[0]]):.0%} of the one before{more}"
        )
        warnings.warn(message, stacklevel=1)  # always from this line, so that Python shows the same message once only


def _day(date):
    """2024-03-15, and the time where there is one."""
    return str(date.date() if date == date.normalize() else date)
