"""The trading floor on which tables learn at every move: as in homework 2, and on unseen days as honest as there."""

import re

import numpy as np
import pytest

from course_lib import QAgent, market
from course_lib.explore.floor import one_digit
from course_lib.explore.market import COSTS, DAYS, EYES, MARKETS, TRADERS, TradingFloor, TrainingFloor, trading_floor

from . import minus, prose
from .test_market import panel, put, rows

PRICES = {
    "rubber band": lambda seed: market.RubberBandMarket().prices(5000, seed=seed),
    "slack rubber band": lambda seed: market.RubberBandMarket(kappa=0.05).prices(5000, seed=seed),
    "random walk": lambda seed: market.RandomWalkMarket().prices(5000, seed=seed),
    "IBM": lambda _: market.real_prices("IBM"),
    "MSFT": lambda _: market.real_prices("MSFT"),
}
ENCODERS = {
    "min-max 60": lambda: market.MinMaxEncoder(60, levels=10),
    "turning grid 8": lambda: market.GridEncoder(8),
    "window 3": lambda: market.WindowEncoder(3),
    "window 8": lambda: market.WindowEncoder(8),
}


@pytest.fixture
def floor():
    return TrainingFloor(cost=0.001)


def homework(name, eyes, cost, seed=0, history=None):
    """(part, positions) in training and in the test, as the homework gets them, written as there."""
    parts = market.split(PRICES[name](seed if history is None else history))
    encoder = ENCODERS[eyes]().fit(parts.training.close)
    agents, episodes = [], 50 * len(parts.training) // 250
    for side in (1, -1):
        env = market.SideEnv(parts.training, encoder, side=side, cost=cost, episode_length=250)
        settings = dict(gamma=0.95, alpha=1, alpha_power=0.6, epsilon=1, mask_actions=True)
        agents.append(QAgent(env, **settings, epsilon_decay=0.1 ** (1 / episodes), seed=seed))
        agents[-1].train(episodes)
    return [
        (part, market.trade(*(market.action_values(agent, part, encoder) for agent in agents)))
        for part in (parts.training, parts.test)
    ]


def sharpe(part, positions, cost):
    return float(market.metrics(market.account(part, positions, cost=cost)).sharpe)


def test_there_is_every_market_and_every_kind_of_eyes():
    assert (list(MARKETS), list(EYES)) == (list(PRICES), list(ENCODERS))


@pytest.mark.parametrize(
    ("name", "eyes", "cost"),
    [("rubber band", "min-max 60", 0.001), ("slack rubber band", "turning grid 8", 0.0), ("IBM", "window 3", 0.0005),
     ("random walk", "window 8", 0.0002), ("MSFT", "min-max 60", 0.01)],
)  # fmt: skip
def test_the_trader_is_that_of_homework_2(floor, name, eyes, cost):
    put(floor, market=name, eyes=eyes, cost=f"{100 * cost:g} %")
    ratios = []
    for days, (part, positions) in zip(DAYS, homework(name, eyes, cost), strict=True):
        put(floor, days=days)
        account = market.account(part, positions, cost=cost)
        assert np.array_equal(floor.judged.account.positions, account.positions)
        assert np.array_equal(floor.judged.account.log_equity, account.log_equity)
        assert floor.judged.part.dates.equals(part.dates)
        known = "These are the days it has learned from. " if days == "training days" else "Unseen days. "
        assert floor.view().message == known + floor.judged.says()
        ratios.append(sharpe(part, positions, cost))
    assert floor.sharpe == pytest.approx(tuple(ratios))
    assert (
        "This trader: {} in training, {} on unseen days.".format(*map(one_digit, ratios)) in panel(floor, "dots").words
    )


def test_the_first_view_is_that_of_the_homework_s_text(floor):
    assert "1 dollar becomes 6.42; 295 legs at 0.1 % took 25.6 % of the money" in floor.view().message
    assert rows(floor)["this trader"][0] == "+542 %"


def test_the_first_view_is_always_the_same():
    assert TrainingFloor().view() == TrainingFloor().view()
    assert trading_floor().still() == trading_floor().still()
    assert TrainingFloor().view().control("cost").at == 3


def test_moving_there_and_back_changes_nothing(floor):
    before = floor.view()
    for name in ("market", "eyes", "days", "cost", "from"):
        at = floor.view().control(name).at
        for stop in (1, 0, at):
            floor.turn(name, stop)
    assert floor.view() == before


def test_a_stretch_beyond_the_shorter_part_moves_into_it(floor):
    put(floor, days="training days", **{"from": "2800"})
    assert floor.shown == slice(2800, 2940)
    put(floor, days="unseen days")
    assert floor.shown.stop == 1000
    assert len(panel(floor, "price").svg) > 1000


def test_twenty_traders_are_those_of_the_homework(floor):
    put(floor, market="random walk", eyes="window 3", cost="0.05 %")
    for done, _ in enumerate(floor.press("try"), 1):
        view = floor.view()
        if done < TRADERS:
            assert (view.progress, view.control("try").idle) == (done / TRADERS, True)
    view = floor.view()
    assert (done, view.progress, view.control("try").idle, floor.press("try")) == (TRADERS, None, True, None)
    for seed in (0, 7, 19):
        both = homework("random walk", "window 3", 0.0005, seed)
        money = np.exp(market.account(*both[1], cost=0.0005).log_equity[-1])
        assert floor.tries[seed] == pytest.approx((*(sharpe(*days, 0.0005) for days in both), money))
    inside, outside, money = np.array(floor.tries).T
    said = f"Sharpe ratio {inside.mean():.1f} ± {inside.std():.1f} in training"
    said += f" and {outside.mean():.1f} ± {outside.std():.1f} on unseen days; {np.sum(money > 1)} of them gained money"
    said = minus(said)
    assert said in view.message
    assert said in panel(floor, "scores").html
    assert "each on a market of its own" in view.message
    assert (
        panel(floor, "dots").svg.count("<circle") - panel(TrainingFloor(), "dots").svg.count("<circle") == TRADERS + 1
    )
    for pair in ((inside[i], outside[i]) for i in range(TRADERS)):
        assert "{} and {}".format(*map(one_digit, pair)) in panel(floor, "dots").words


def test_on_the_random_walk_nothing_is_to_be_won(floor):
    """Whatever it sees, and however splendid it is in training."""
    for eyes in EYES:
        put(floor, market="random walk", eyes=eyes, cost="0.05 %")
        list(floor.press("try"))
        inside, outside, money = np.array(floor.tries).T
        assert outside.mean() < 0.1
        assert np.median(money) < 1
        assert "There is no pattern" in panel(floor, "scores").html
    assert inside.mean() > 12, "window 8 remembers"
    assert np.log(money).mean() < 0


def test_whoever_moves_on_stops_the_twenty(floor):
    work = floor.press("try")
    next(work), next(work)
    put(floor, eyes="window 3")
    assert (floor.view().progress, floor.view().control("try").idle, floor.tries) == (None, False, [])
    assert list(work) == []
    assert floor.tries == []
    put(floor, eyes="min-max 60")
    assert len(floor.tries) == 2
    assert len(list(floor.press("try"))) == TRADERS - 2, "it goes on from where it was"
    assert len(floor.tries) == TRADERS
    put(floor, days="training days", **{"from": "50"})
    assert "20 traders" in panel(floor, "scores").html
    assert "20 traders" not in floor.view().message


def test_work_that_comes_too_late_leaves_the_tries_of_others_alone(floor):
    work = floor.press("try")
    put(floor, eyes="window 3")
    assert list(work) == []
    assert floor.tries == []


def test_bar_and_idle_button_show_at_once_and_looking_writes_nothing(floor):
    assert (floor.tries, floor._tries) == ([], {})
    work = floor.press("try")
    assert (floor.view().progress, floor.view().control("try").idle) == (0, True)
    assert floor.press("try") is None, "it is under way already"
    put(floor, eyes="window 3")
    newer = floor.press("try")
    put(floor, eyes="min-max 60")
    newest = floor.press("try")
    next(newest)
    work.close(), newer.close()
    assert floor.view().progress == 1 / TRADERS, "older work that ends does not end the newer"
    newest.close()
    assert (floor.view().progress, floor.view().control("try").idle) == (None, False)


def test_after_a_fault_the_button_can_be_pressed_again(floor, monkeypatch):
    def fault(*_):
        raise RuntimeError("no room")

    with monkeypatch.context() as broken:
        broken.setattr("course_lib.explore.market.result", fault)
        with pytest.raises(RuntimeError, match="no room"):
            next(floor.press("try"))
    assert (floor.view().progress, floor.view().control("try").idle) == (None, False)
    next(floor.press("try"))
    assert len(floor.tries) == 1


def test_looking_elsewhere_does_not_stop_the_twenty(floor):
    put(floor, eyes="window 3", cost="0.02 %")
    work = floor.press("try")
    next(work)
    put(floor, days="training days", **{"from": "100"})
    assert len(list(work)) == TRADERS - 1


def test_in_the_widget_the_twenty_come_by_themselves():
    explorer = trading_floor(cost=0.001)
    explorer.do("turn", "eyes", 2)
    explorer.do("press", "try")
    assert explorer.wait(60)
    assert (len(explorer.state.tries), explorer.progress) == (TRADERS, None)
    assert re.search("20 traders, each on a market of its own: Sharpe ratio", explorer.message)


def test_a_real_share_has_one_history_only(floor):
    put(floor, market="IBM")
    work = floor.press("try")
    next(work), next(work)
    assert "each with other dice" not in panel(floor, "scores").html
    list(work)
    assert "each with other dice" in panel(floor, "scores").html
    assert "Nobody knows whether there is a pattern" in panel(floor, "scores").html


# --- what the homework says of it -------------------------------------------------------------------------------------


def test_homework_2_tells_what_the_cost_does(floor):
    said, legs = prose("05_homework_2.ipynb"), {}
    for cost in ("0 %", "0.1 %", "0.2 %", "1 %"):
        put(floor, cost=cost)
        legs[cost] = (int(floor.judged.account.trades), floor.judged.money)
    assert "{0} legs at no cost, {1} at 0.1 %, {3} at 1 %.".format(*(number for number, _ in legs.values())) in said
    assert legs["0.2 %"][1] > legs["0.1 %"][1], "it ends with more than at 0.1 %"
    assert f"1 dollar still becomes {legs['1 %'][1]:.2f}." in said
    (_, positions) = homework("rubber band", "min-max 60", 0.001)[1]
    fixed = put(TradingFloor(floor.judged.part, {"mine": positions}), cost="1 %").judged
    eaten = 100 * (1 - 0.99**fixed.account.trades)
    assert f"{fixed.money:.3f} dollars: the {fixed.account.trades} legs have taken {eaten:.1f} % of the money" in said
    assert f"a pair still made {legs['1 %'][1]:.2f} dollars" in said


def test_homework_2_tells_of_luck(floor):
    said = prose("05_homework_2.ipynb")
    put(floor, market="random walk", eyes="window 8", cost="0.05 %", days="training days")
    known, unseen = floor.judged.money, put(floor, days="unseen days").judged.money
    assert (
        f"{float(f'{known:.3g}'):,.0f} dollars on the days that it knows by heart, {unseen:.2f} on unseen ones" in said
    )
    list(floor.press("try"))
    inside, outside, money = np.array(floor.tries).T
    assert np.sum(money > 1) == 4
    assert "Four of twenty gain money" in said
    assert f"{inside.mean():.1f} in training and −{-outside.mean():.1f} outside" in said
    put(floor, market="MSFT", eyes="min-max 60")
    lucky = floor.judged
    assert f"A return of {100 * (lucky.money - 1):.0f} % and a percentile of {lucky.percentile:.0f} look" in said
    list(floor.press("try"))
    _, outside, money = np.array(floor.tries).T
    assert np.sum(money > 1) == 9
    assert f"nine gain money; the Sharpe ratio is {outside.mean():.1f} ± {outside.std():.1f}" in said


def test_homework_3_tells_what_tables_make_of_it():
    said = prose("07_homework_3.ipynb")
    medians = {}
    for eyes in ("min-max 60", "window 8"):
        part = homework("rubber band", eyes, 0.001)[1][0]
        takers = np.array([homework("rubber band", eyes, 0.001, seed, 0)[1][1] for seed in range(20)])
        accounts = {cost: market.account(part, takers, cost=cost) for cost in COSTS}
        ends = {cost: np.exp(account.log_equity[:, -1]) for cost, account in accounts.items()}
        medians[eyes] = {cost: np.median(money) for cost, money in ends.items()}
        if eyes == "min-max 60":
            assert np.mean(ends[0.001].round(2) == 6.42) > 0.5
            assert f"1 dollar becomes {ends[0.001][0]:.2f} on unseen days" in said
        else:
            assert f"most of that goes into its {np.median(accounts[0.0].trades):.0f} legs" in said
            ranks = [market.percentile(part, taken, cost=0.001) for taken in takers]
            assert np.mean(np.array(ranks) > 90) >= 0.9
    assert [cost for cost in COSTS if medians["window 8"][cost] < 1] == [0.002, 0.005, 0.01]
    assert [cost for cost in COSTS if medians["min-max 60"][cost] < 1] == [0.01]
    assert f"has earned {100 * (medians['window 8'][0.001] - 1):.0f} % in 1,000 bars" in said
    assert f"At no cost it makes {100 * (medians['window 8'][0.0] - 1):.0f} %" in said
