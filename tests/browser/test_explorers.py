"""Every explorer of every lesson, worked by keyboard and by mouse in a real JupyterLab: it shows what it should."""

import pytest

from .hands import ARROWS, KEY_OF, notebooks_with_explorers, open_explorers
from .lab import THEMES, WIDTHS

SERIOUS = ("serious", "critical")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Where the twins keep their files, as the lessons do in theirs."""
    return tmp_path_factory.mktemp("twins")


@pytest.fixture(scope="module", params=notebooks_with_explorers().items(), ids=lambda item: item[0])
def explorers(request, lab, folder):
    with open_explorers(lab, *request.param, folder) as opened:
        yield opened


def controls_of(hands, *kinds):
    return [control for control in hands.twin.controls if control["kind"] in kinds]


def step(control):
    """The key that moves a control by one stop, and the stop it leads to."""
    last = len(control["texts"]) - 1
    if control["kind"] == "switch":
        return "Space", 1 - control["at"]
    if control["at"] < last:
        return KEY_OF[control["kind"]], control["at"] + 1
    return {"slider": "ArrowLeft", "choice": "ArrowUp"}[control["kind"]], control["at"] - 1


def click_in_the_middle(hands, place):
    """Whatever is drawn on top there: that is what a learner clicks on."""
    place.scroll_into_view_if_needed()
    box = place.bounding_box()
    hands.page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)


def test_first_view_is_that_of_the_state(explorers):
    for hands in explorers[1]:
        hands.assert_alike("opening it")


def test_every_control_works_by_keyboard(explorers):
    for hands in explorers[1]:
        for name in [control["name"] for control in hands.twin.controls]:
            control = next((one for one in hands.twin.controls if one["name"] == name), None)
            if control is None:  # another control has taken it away
                continue
            hands.control(name).focus()
            if control["kind"] == "button":
                hands.page.keyboard.press("Enter")
                hands.do("press", name)
            else:
                key, at = step(control)
                hands.page.keyboard.press(key)
                hands.do("turn", name, at)
            hands.assert_alike(f"the key for {name}")


def test_every_control_works_by_mouse(explorers):
    for hands in explorers[1]:
        for name in [control["name"] for control in hands.twin.controls]:
            control = next((one for one in hands.twin.controls if one["name"] == name), None)
            if control is None:
                continue
            place = hands.control(name)
            if control["kind"] == "button":
                place.click()
                hands.do("press", name)
            elif control["kind"] == "switch":
                place.click()
                hands.do("turn", name, 1 - control["at"])
            elif control["kind"] == "choice":
                other = (control["at"] + 1) % len(control["texts"])
                place.select_option(index=other)
                hands.do("turn", name, other)
            else:
                box = place.bounding_box()
                place.click(position={"x": box["width"] * 0.3, "y": box["height"] / 2})
                hands.do("turn", name, int(place.input_value()))
            hands.assert_alike(f"a click on {name}")


def test_boards_work_by_arrow_keys_and_by_mouse(explorers):
    for hands in explorers[1]:
        for board in range(hands.board.count()):
            hands.board.nth(board).focus()
            for key in ARROWS:
                hands.page.keyboard.press(key)
                hands.do("arrow", key)
                hands.assert_alike(key)
            for cell in (5, 9):
                click_in_the_middle(hands, hands.board.nth(board).locator(f'[data-cell="{cell}"]').first)
                hands.do("choose", cell)
                hands.assert_alike(f"a click on cell {cell}")


def test_twenty_fast_moves_end_at_the_last_value(explorers):
    for hands in explorers[1]:
        for control in controls_of(hands, "slider"):
            last = len(control["texts"]) - 1
            there, back = ("ArrowRight", "ArrowLeft") if control["at"] < last / 2 else ("ArrowLeft", "ArrowRight")
            place = hands.control(control["name"])
            place.focus()
            for key in [there] * 13 + [back] * 3 + [there] * 4:
                hands.page.keyboard.press(key)
            at = int(place.input_value())
            assert at != control["at"]
            hands.do("turn", control["name"], at)
            hands.assert_alike(f"twenty moves of {control['name']}")


def test_pressing_fast_loses_no_press(explorers):
    for hands in explorers[1]:
        for control in controls_of(hands, "button")[:1]:
            hands.control(control["name"]).focus()
            for _ in range(10):
                hands.page.keyboard.press("Enter")
            for _ in range(10):
                hands.do("press", control["name"])
            hands.assert_alike(f"ten presses of {control['name']}")


@pytest.mark.parametrize("theme", THEMES)
def test_accessibility(explorers, theme):
    """axe-core finds nothing serious: names, roles, contrast of 4.5 to 1, focus."""
    from axe_playwright_python.sync_playwright import Axe

    notebook, all_hands = explorers
    notebook.dress(theme, WIDTHS[0])
    found = Axe().run(notebook.lab.page, context=".course-explorer").response
    assert len(found["passes"]) > 5, "axe has looked at nothing"
    faults = [fault for fault in found["violations"] if fault["impact"] in SERIOUS]
    assert not faults, "\n".join(f"{f['id']}: {f['help']}: {[n['html'][:200] for n in f['nodes']]}" for f in faults)


def test_nothing_is_too_wide_after_all_that(explorers):
    notebook, _ = explorers
    for theme in THEMES:
        for width in WIDTHS:
            notebook.dress(theme, width)
            assert notebook.too_wide() == [], f"{theme} {width}"


def test_arrow_keys_leave_the_notebook_alone(explorers):
    """JupyterLab would take them for its own, and go to another cell."""
    for hands in explorers[1]:
        focusable = hands.board if hands.board.count() else hands.root.locator("input[type=range]")
        if focusable.count():
            place = focusable.first
            place.focus()
            for key in ARROWS:
                hands.page.keyboard.press(key)
                assert place.evaluate("node => node === document.activeElement"), f"{key} has taken the focus away"


def test_the_browser_does_not_complain(explorers):
    assert explorers[0].complaints == []
    assert [error for cell in explorers[0].look()["cells"] for error in cell["errors"] + cell["warnings"]] == []
