"""The trading floor: what learns, what is judged, and that pictures and words hold the same numbers as the market's."""

import re
import xml.etree.ElementTree as ElementTree
from html import unescape

import numpy as np
import pytest
from market_worlds import closes

from course_lib import explore, market
from course_lib.explore.drawing.chart import Chart, log_ticks
from course_lib.explore.floor import OWN_LINES, judge
from course_lib.explore.market import COSTS, TradingFloor, TrainingFloor
from course_lib.plots.picture import PALETTE

TEST = market.split(market.real_prices("IBM")).test
RNG = np.random.default_rng(5)
COINS = np.repeat(RNG.integers(-1, 2, (4, 66)), 10, axis=1)[:, : len(TEST)].astype(np.int8)
OTHERS = np.repeat(RNG.integers(-1, 2, (2, 33)), 20, axis=1)[:, : len(TEST)].astype(np.int8)


def given(**more):
    return TradingFloor(TEST, {"coins": COINS, "slow coins": OTHERS, "hold": market.buy_and_hold(TEST)}, **more)


def put(floor, **values):
    for name, value in values.items():
        control = floor.view().control(name)
        floor.turn(name, control.texts.index(value))
    return floor


def panel(floor, name):
    return next(panel for panel in floor.view().panels if panel.name == name)


def rows(floor):
    """The cells of the table, by the trader's name."""
    table = re.search(r"<tbody>(.*)</tbody>", panel(floor, "scores").html).group(1)
    cells = [re.findall(r"<t[dh][^>]*>(.*?)</t[dh]>", row) for row in table.split("</tr>")[:-1]]
    return {unescape(name): values for name, *values in cells}


def as_number(text):
    return float(text.removesuffix(" %").replace(",", "").replace("−", "-"))


# --- judging ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("cost", [0.0, 0.0005, 0.01])
def test_a_judgement_is_that_of_the_market(cost):
    judged = judge(TEST, COINS[0], cost)
    traders = {
        "trader": COINS[0], "buy and hold": market.buy_and_hold(TEST), "random": market.random_shifts(COINS[0]),
        "oracle": market.oracle(TEST, cost=cost),
    }  # fmt: skip
    board = market.scoreboard(TEST, traders, cost=cost)
    assert list(judged.scores) == list(traders)
    for name, scores in judged.scores.items():
        assert list(scores.values()) == pytest.approx(board.loc[name].to_list())
    assert judged.percentile == pytest.approx(market.percentile(TEST, COINS[0], cost=cost))
    own = market.account(TEST, COINS[0], cost=cost).log_equity
    assert judged.money == pytest.approx(np.exp(own[-1]))
    assert judged.curves["trader"] == pytest.approx(own[judged.places])
    assert judged.places[[0, -1]].tolist() == [0, len(TEST) - 1]
    chance = market.account(TEST, traders["random"], cost=cost).log_equity[:, judged.places]
    assert judged.band == pytest.approx(np.percentile(chance, [5, 50, 95], axis=0))


def test_what_the_cost_ate_is_what_is_lacking():
    """Legs and the share of the money, against the same trades without cost."""
    part, positions = market.split(market.RubberBandMarket().prices(1000)).test, np.repeat([1, 0, -1, 1], 50)
    judged = judge(part, positions, 0.01)
    free = np.exp(market.account(part, positions, cost=0.0).log_equity[-1])
    eaten = 1 - judged.money / free
    assert f"5 legs at 1 % took {100 * eaten:.1f} % of the money" in judged.says()
    assert "5 legs at 0 % took nothing" in judge(part, positions, 0.0).says()
    assert "it never trades" in judge(part, market.flat(part), 0.01).says()
    assert "1 leg at 0.01 % took 0.0 %" in judge(part, market.buy_and_hold(part), 0.0001).says()


def test_a_trader_like_all_others_has_the_percentile_50():
    assert (
        "1 dollar becomes 1; it never trades. Its percentile among 200 random traders is 50."
        in judge(TEST, market.flat(TEST), 0.001).says()
    )


def test_ruin_is_said():
    part = market.Part("test", closes([100, 101, 250, 100, 99]), 0)
    assert "That is ruin." in judge(part, np.array([0, -1, -1, -1, -1]), 0.0).says()


# --- traders that come with their positions ---------------------------------------------------------------------------


def test_the_numbers_in_the_table_are_those_of_the_scoreboard():
    floor = put(given(), all="on", which="3 of 4", cost="0.2 %")
    shown = rows(floor)
    assert list(shown) == ["coins", "slow coins", "hold", "buy and hold", "random", "oracle"]
    taken = {"coins": COINS[2], "slow coins": OTHERS[1], "hold": market.buy_and_hold(TEST)}
    taken |= {"random": market.random_shifts(COINS[2]), "oracle": market.oracle(TEST, cost=0.002)}
    board = market.scoreboard(TEST, taken, cost=0.002)
    for name, row in board.iterrows():
        gained, ratio, fall, legs, exposure = map(as_number, shown[name])
        for said, number in zip((gained, fall, exposure), 100 * row.iloc[[0, 2, 4]], strict=True):
            assert said == pytest.approx(number, abs=0.051 if abs(number) < 9.95 else 0.51, rel=0.0051)
        assert (ratio, legs) == (pytest.approx(row["Sharpe"], abs=0.051), row["legs"])
    columns = re.findall(r'<th scope="col"[^>]*>([^<]*)</th>', panel(floor, "scores").html)
    assert columns == ["return", "Sharpe", "drawdown", "legs", "in trade"]
    assert panel(floor, "scores").html.count('<th scope="row"') == len(shown)
    numbers = re.findall(r"<td[^>]+>", panel(floor, "scores").html)
    assert len(numbers) == 5 * len(shown)
    assert all("text-align:right" in cell for cell in numbers), "units below units"


def test_the_others_are_beside_it_only_when_asked_for():
    floor = given()
    assert list(rows(floor)) == ["coins", "buy and hold", "random", "oracle"]
    assert "slow coins" not in panel(floor, "wealth").svg
    put(floor, all="on")
    for name in ("coins", "slow coins", "hold"):
        assert f">{name}: " in panel(floor, "wealth").svg
    put(floor, trader="slow coins")
    yardsticks, thick = (
        rows(floor),
        re.search(r'stroke="(#\w+)" stroke-width="2.8"', panel(floor, "wealth").svg).group(1),
    )
    assert thick == PALETTE[OWN_LINES[1]], "the chosen one"
    put(floor, all="off")
    assert yardsticks.items() > rows(floor).items(), "the yardsticks are its own"
    put(floor, trader="hold")
    assert list(rows(floor)) == ["hold", "buy and hold", "random", "oracle"]
    assert rows(floor)["hold"] == rows(floor)["buy and hold"]


def test_the_legend_says_what_becomes_of_the_money():
    floor = put(given(), cost="0.1 %", which="2 of 4")
    ends = {
        "coins": COINS[1], "buy and hold": market.buy_and_hold(TEST), "oracle": market.oracle(TEST, cost=0.001)
    }  # fmt: skip
    words = panel(floor, "wealth").words
    for name, taken in ends.items():
        money = float(np.exp(market.account(TEST, taken, cost=0.001).log_equity[-1]))
        assert f"{name}: {money:.3g}" in words
    ends = market.account(TEST, market.random_shifts(COINS[1]), cost=0.001).log_equity[:, -1]
    least, most = np.exp(np.percentile(ends, [5, 95]))
    assert f"random, 5 % to 95 % of 200: {least:.3g} to {most:.3g}" in words
    drawn = panel(floor, "wealth").svg
    assert all(part in drawn for part in re.findall(r"[a-z ]+: [^;]*(?=[;.]) ", words))
    assert "leaves the picture" in words
    assert floor.view().message.startswith(f"coins: {floor.judged.says()}")


def test_all_of_a_kind_are_told_of():
    floor = given(cost=0.01)
    ends = np.exp(market.account(TEST, COINS, cost=0.01).log_equity[:, -1])
    low, middle, high = np.percentile(ends, [5, 50, 95])
    said = f"coins, all 4: 1 dollar becomes {low:.3g} to {high:.3g} (5 % to 95 %), median {middle:.3g}."
    assert said in panel(floor, "scores").html
    assert "all 1:" not in panel(put(floor, trader="hold"), "scores").html


def test_which_of_them_is_asked_only_where_there_are_several():
    floor = put(given(), which="4 of 4")
    assert np.array_equal(floor.judged.account.positions, market.account(TEST, COINS[3]).positions)
    put(floor, trader="slow coins")
    assert floor.view().control("which").texts == ("1 of 2", "2 of 2")
    assert np.array_equal(floor.judged.account.positions, market.account(TEST, OTHERS[1]).positions)
    with pytest.raises(ValueError, match="which must be from 0 to 1, got 3"):
        floor.turn("which", 3)
    put(floor, trader="hold")
    assert "which" not in [control.name for control in floor.view().controls]
    alone = TradingFloor(TEST, {"me": COINS[0]}).view()
    assert [control.name for control in alone.controls] == ["cost", "from"]


def test_marks_and_strip_are_the_trades_of_the_stretch():
    floor = put(given(), **{"from": "300"})
    held, before = COINS[0][300:450], COINS[0][299:449]
    drawn, told = panel(floor, "price").svg, panel(floor, "price").words
    counts = [int(np.sum((held == side) & (before != side))) for side in (1, -1, 0)]
    assert f"Trades: buy: {counts[0]}, sell short: {counts[1]}, close: {counts[2]}." in told
    triangles = [node for node in ElementTree.fromstring(drawn).iter() if node.tag.endswith("polygon")]
    assert len(triangles) == counts[0] + counts[1] + 2, "and those of the legend"
    assert drawn.count('stroke-width="1.5"') == counts[2] + 1
    changes = np.flatnonzero(np.diff(held[:-1])) + 1
    runs = [stretch[0] for stretch in np.split(held[:-1], changes)]
    assert drawn.count('fill="url(#held-long)"') == runs.count(1)
    assert drawn.count('fill="url(#held-short)"') == runs.count(-1)
    close = TEST.close.to_numpy()[300:450]
    assert f"Price of bars 300 to 449, {TEST.dates[300]:%Y-%m-%d} to {TEST.dates[449]:%Y-%m-%d}:" in told
    assert f"{close[0]:.4g} at first, {close[-1]:.4g} at last, between {close.min():.4g} and {close.max():.4g}" in told


def test_a_position_held_at_the_beginning_of_a_stretch_is_no_trade_there():
    floor = TradingFloor(TEST, {"hold": market.buy_and_hold(TEST)})
    assert "buy: 1," in panel(floor, "price").words
    assert "buy: 0," in panel(put(floor, **{"from": "50"}), "price").words
    assert panel(floor, "price").svg.count('fill="url(#held-long)"') == 1, "held to the end"


def test_the_slider_reaches_every_bar_and_no_further():
    floor = given()
    stops = floor.view().control("from").texts
    assert stops[:2] == ("0", "50")
    last = put(floor, **{"from": stops[-1]}).shown
    assert last.stop == len(TEST)
    assert last.start >= len(TEST) - 150
    short = market.Part("test", closes(np.linspace(100, 110, 9)), 0)
    floor = TradingFloor(short, {"me": np.ones(9, int)})
    assert [control.name for control in floor.view().controls] == ["cost"]
    assert floor.shown == slice(0, 9)


def test_parts_of_two_bars_are_drawn_too():
    tiny = market.Part("test", closes([100, 100]), 0)
    floor = TradingFloor(tiny, {"me": np.array([1, 1])})
    for shown in floor.view().panels[:2]:
        ElementTree.fromstring(shown.svg)
        assert "nan" not in shown.svg


def test_names_cannot_break_the_page():
    floor = TradingFloor(TEST, {"<b>&": COINS[0]})
    assert rows(floor)["<b>&"]
    assert "<b>" not in "".join(panel.svg + panel.html for panel in floor.view().panels)


@pytest.mark.parametrize(
    ("positions", "words"),
    [
        (COINS, "got a ndarray"), (None, "got a NoneType"), ({}, "got 0 of them"),
        ({str(i): COINS for i in range(4)}, "one to 3 traders, got 4 of them"),
        ({"me": COINS[:, :5]}, "me: positions must be whole numbers, one for each of"),
        ({"me": COINS * 2}, "me: positions must be -1, 0 or 1"),
        ({"me": COINS * 0.5}, "me: positions must be whole numbers"),
        ({"me": COINS[None]}, r"me: positions must be int\[N\] or int\[E, N\], got \[1, 4,"),
        ({"me": COINS[:0]}, "got \\[0,"),
    ],
)  # fmt: skip
def test_other_positions_are_refused(positions, words):
    with pytest.raises(ValueError, match=words):
        TradingFloor(TEST, positions)


def test_bad_input_changes_nothing():
    for floor in (given(), TrainingFloor()):
        before = floor.view()
        for name, at in (("cost", 8), ("cost", -1), ("cost", 1.0), ("from", 999), ("price", 0), ("which", 9)):
            with pytest.raises(ValueError, match=name):
                floor.turn(name, at)
        with pytest.raises(ValueError, match="button"):
            floor.press("buy")
        assert floor.view() == before
    for call in (TrainingFloor, lambda cost: TradingFloor(TEST, {"me": COINS}, cost=cost)):
        with pytest.raises(ValueError, match=r"cost must be one of 0.0, 0.0001, .*, got 0.3"):
            call(cost=0.3)


def test_one_function_gives_both_kinds():
    assert isinstance(explore.trading_floor().state, TrainingFloor)
    explorer = explore.trading_floor(TEST, {"me": COINS}, cost=0.002)
    assert isinstance(explorer.state, TradingFloor)
    assert explorer.state.view().control("cost").at == COSTS.index(0.002)
    for half in ({"part": TEST}, {"positions": {"me": COINS}}):
        with pytest.raises(ValueError, match="needs both"):
            explore.trading_floor(**half)


# --- what the chart can do for it -------------------------------------------------------------------------------------


def test_a_short_log_axis_has_round_numbers_all_the_same():
    assert log_ticks(0.65, 1.75) == [0.8, 1.0, 1.2, 1.4, 1.6]
    assert log_ticks(0.9, 6) == [1, 2, 5]


def test_large_powers_of_ten_are_written_short():
    drawn = Chart("", x=(0, 1), y=(1e-6, 1e7), xlabel="", ylabel="", log=True).svg()
    written = re.findall(r">([^<>]+)</text>", drawn)
    assert {"10⁷", "10⁻⁵", "10,000", "100", "0.001"} <= set(written)


def test_triangles_point_where_they_say():
    chart = Chart("", x=(0, 1), y=(0, 1), xlabel="", ylabel="")
    chart.points(0.5, 0.5, shape="up")
    chart.points(0.5, 0.5, shape="down")
    up, down = (
        np.array([[float(number) for number in corner.split(",")] for corner in corners.split()])
        for corners in re.findall(r'<polygon points="([^"]+)"', chart.svg())
    )
    assert up[2, 1] < up[0, 1] == up[1, 1]
    assert down[2, 1] > down[0, 1] == down[1, 1]


def test_room_in_the_legend_is_nobody_else_s():
    chart = Chart("", x=(0, 1), y=(0, 1), xlabel="", ylabel="", legend=4)
    first, second = chart.room(2), chart.room(1)
    chart.legend("last", 0)
    last = float(re.findall(r'<text x="48" y="([\d.]+)"', chart.svg())[0])
    assert chart.bottom < first < second == first + 36 < second + 18 < last < chart.sketch.height
