"""A learner's own file of prices: read by its names, adjusted where it can be, and never mended."""

import numpy as np
import pandas as pd
import pytest
from market_worlds import random_bars

from course_lib.market import PriceDataError, read_csv

GOOD = {  # the header and two lines
    "as the course writes it": "date,open,high,low,close,volume\n2024-03-14,1,3,0.5,2,10\n2024-03-15,2,4,1.5,3,20\n",
    "capitals and blanks": " Date , Open,High ,LOW,Close,Volume\n2024-03-14,1,3,0.5,2,10\n2024-03-15,2,4,1.5,3,20\n",
    "another order": "Volume,Close,Low,High,Open,Date\n10,2,0.5,3,1,2024-03-14\n20,3,1.5,4,2,2024-03-15\n",
    "an index without a name": ",open,high,low,close,volume\n2024-03-14,1,3,0.5,2,10\n2024-03-15,2,4,1.5,3,20\n",
    "dates by another name, in the first column": "Day,open,high,low,close,volume\n2024-03-14,1,3,0.5,2,10\n"
    "2024-03-15,2,4,1.5,3,20\n",
    "adjusted by nothing": "Date,Open,High,Low,Close,Adj Close,Volume\n2024-03-14,1,3,0.5,2,2,10\n"
    "2024-03-15,2,4,1.5,3,3,20\n",
}


def written(tmp_path, text):
    path = tmp_path / "prices.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


@pytest.mark.filterwarnings("ignore:split or crash")
@pytest.mark.parametrize("text", GOOD.values(), ids=GOOD.keys())
def test_a_file_is_read_by_its_names(tmp_path, text):
    prices = read_csv(written(tmp_path, text))
    assert prices.index.name == "date"
    assert prices.index.tolist() == [pd.Timestamp("2024-03-14"), pd.Timestamp("2024-03-15")]
    wanted = {"open": [1, 2], "high": [3, 4], "low": [0.5, 1.5], "close": [2, 3], "volume": [10, 20]}
    assert {name: prices[name].tolist() for name in wanted} == wanted


@pytest.mark.filterwarnings("ignore:split or crash")
@pytest.mark.parametrize("name", ["adj_close", "Adj Close", "ADJ CLOSE"])
def test_prices_are_adjusted_where_the_file_says_how(tmp_path, name):
    """A split in two on the second day, and a dividend worth a fifth."""
    text = f"date,open,high,low,close,volume,{name}\n2024-03-14,4,8,2,6,10,2.4\n2024-03-15,2,4,1.5,3,20,3\n"
    prices = read_csv(written(tmp_path, text))
    assert prices.columns.tolist() == ["open", "high", "low", "close", "volume"]
    for column, wanted in {"open": [1.6, 2], "high": [3.2, 4], "low": [0.8, 1.5], "close": [2.4, 3]}.items():
        assert prices[column].tolist() == pytest.approx(wanted), column
    assert prices["volume"].tolist() == [10, 20]


@pytest.mark.filterwarnings("ignore:split or crash")
def test_closes_alone_will_do_with_and_without_adjustment(tmp_path):
    assert read_csv(written(tmp_path, "date,close\n2024-03-14,2\n2024-03-15,3\n"))["close"].tolist() == [2, 3]
    prices = read_csv(written(tmp_path, "date,close,adj close\n2024-03-14,2,1\n2024-03-15,3,3\n"))
    assert prices.columns.tolist() == ["close"]
    assert prices["close"].tolist() == [1, 3]


def test_what_pandas_has_written_comes_back(tmp_path):
    prices = random_bars(60, seed=2)
    prices.to_csv(tmp_path / "own.csv")
    again = read_csv(tmp_path / "own.csv")
    pd.testing.assert_frame_equal(again[prices.columns], prices, check_freq=False, rtol=1e-15)
    pd.testing.assert_frame_equal(read_csv(str(tmp_path / "own.csv")), again)


def test_times_of_day_are_kept(tmp_path):
    prices = read_csv(written(tmp_path, "date,close\n2024-03-15 09:00,2\n2024-03-15 10:00,2.1\n"))
    assert (np.diff(prices.index) == np.timedelta64(1, "h")).all()


LINES = "date,open,high,low,close,volume\n2024-03-14,1,3,0.5,2,10\n{}\n2024-03-18,2,4,1.5,3,20\n"
BAD = {  # what is in the file, and the words about it
    "nothing": ("", ["prices.csv", "no file of comma-separated values that can be read"]),
    "no text": (b"\xff\xfe\x00\x81", ["prices.csv", "no file of comma-separated values that can be read"]),
    "lines of several lengths": ("date,close\n2024-03-14,1\n2024-03-15,1,2,3\n", ["can be read", "line 3"]),
    "a header and no more": ("date,close\n", ["2 rows of prices are needed, 0 are given"]),
    "a header and no more, to be adjusted": ("date,close,adj_close\n", ["2 rows of prices are needed, 0 are given"]),
    "dates and no more": ("date\n2024-03-14\n2024-03-15\n", ["column close is missing", "there are: none"]),
    "other columns": (
        "date,price\n2024-03-14,1\n2024-03-15,1\n",
        ["column close is missing; there are: price", "Rename"],
    ),
    "an adjusted close and no close": ("date,adj_close\n2024-03-14,1\n2024-03-15,1\n", ["column close is missing"]),
    "some columns": ("date,open,close\n2024-03-14,1,1\n", ["column high and low and volume is missing", "open, close"]),
    "a column twice": (
        "date,close,Close\n2024-03-14,1,1\n",
        ["every column must be there once, got date, close, close"],
    ),
    "a column twice, to be adjusted": (
        "date,close,Close,adj close\n2024-03-14,1,1,1\n",
        ["every column must be there once"],
    ),
    "no dates": ("open,close\n1,2\n1,2\n", ["column 'open'", "must hold dates such as 2024-03-15", "numbers"]),
    "years as dates": (
        "date,close\n2024,2\n2025,2\n",
        ["column 'date'", "must hold dates such as 2024-03-15", "numbers"],
    ),
    "dates of another kind": (
        "date,close\n03/14/2024,1\n03/15/2024,1\n",
        ["column 'date'", "dates such as 2024-03-15"],
    ),
    "semicolons": ("date;close\n2024-03-14;1\n", ["column 'date;close'", "must hold dates such as 2024-03-15"]),
    "a date left out": (LINES.format(",1,3,0.5,2,10"), ["no date in row 1", "remove the row or give it its date"]),
    "a date twice": (LINES.format("2024-03-14,1,3,0.5,2,10"), ["2024-03-14 is there twice", "keep one of its rows"]),
    "dates that go back": (
        LINES.format("2024-03-13,1,3,0.5,2,10"),
        ["must increase, but 2024-03-13 comes after 2024-03-14", "sort_index"],
    ),
    "a price left out": (
        LINES.format("2024-03-15,1,3,0.5,,10"),
        ["column 'close' holds NaN on 2024-03-15", "correct it"],
    ),
    "a comma in a number": (
        LINES.format('2024-03-15,1,3,0.5,"1,5",10'),
        ["column 'close' must hold numbers", "'1,5' on 2024-03-15", "pandas.to_numeric"],
    ),
    "a price of zero": (LINES.format("2024-03-15,1,3,0,2,10"), ["column 'low' holds zero on 2024-03-15"]),
    "a close above the high": (
        LINES.format("2024-03-15,1,3,0.5,3.5,10"),
        ["'close' is outside low and high on 2024-03-15", "correct"],
    ),
    "an adjusted close of nothing": (
        "date,close,adj_close\n2024-03-14,1,1\n2024-03-15,1,0\n",
        ["column 'adj_close' holds zero on 2024-03-15"],
    ),
    "an adjusted close left out": (
        "date,close,adj_close\n2024-03-14,1,1\n2024-03-15,1,\n",
        ["column 'adj_close' holds NaN on 2024-03-15"],
    ),
    "an adjusted close that is text": (
        "date,close,adj_close\n2024-03-14,1,1\n2024-03-15,1,-\n",
        ["column 'adj_close' must hold numbers", "'-' on 2024-03-15"],
    ),
    "neither date nor adjusted price": ("date,close,adj_close\n,,1\n2024-03-15,1,1\n", ["no date in row 0"]),
}


@pytest.mark.parametrize("kind", BAD)
def test_a_file_that_cannot_be_traded_is_refused_in_one_clear_sentence(tmp_path, kind):
    text, words = BAD[kind]
    path = written(tmp_path, text)
    before = path.read_bytes()
    with pytest.raises(PriceDataError, match=r"^[^\n]+$") as error:
        read_csv(path)
    assert all(word in str(error.value) for word in words), error.value
    assert path.read_bytes() == before


@pytest.mark.parametrize("path", ["no_such_file.csv", ".", None, 5, b"prices.csv", ["prices.csv"]])
def test_what_is_no_file_is_refused_too(path):
    with pytest.raises(PriceDataError, match=r"^[^\n]*no file of comma-separated values that can be read[^\n]*$"):
        read_csv(path)
