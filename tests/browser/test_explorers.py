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


def last_put(place):
    """Where a slider was put last, which the explorer may have taken back since; None: it was not moved."""
    return place.evaluate(
        """slider => {
            const put = slider.dataset.put ?? null;
            slider.oninput = () => (slider.dataset.put = slider.value);
            delete slider.dataset.put;
            return put === null ? null : Number(put);
        }"""
    )


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
                place.click(force=control["idle"])  # playwright waits for buttons that say they are disabled
                hands.do("press", name)
            elif control["kind"] == "switch":
                place.click()
                hands.do("turn", name, 1 - control["at"])
            elif control["kind"] == "choice":
                other = (control["at"] + 1) % len(control["texts"])
                place.select_option(index=other)
                hands.do("turn", name, other)
            else:
                last_put(place)
                box = place.bounding_box()
                place.click(position={"x": box["width"] * 0.3, "y": box["height"] / 2})
                at = last_put(place)
                if at is not None:  # else it stood there already
                    hands.do("turn", name, at)
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
            last_put(place)
            for key in [there] * 13 + [back] * 3 + [there] * 4:
                hands.page.keyboard.press(key)
            at = last_put(place)
            assert at != control["at"]
            hands.do("turn", control["name"], at)
            hands.assert_alike(f"twenty moves of {control['name']}")


def test_pressing_fast_loses_no_press(explorers):
    for hands in explorers[1]:
        for control in [button for button in controls_of(hands, "button") if not button["idle"]][:1]:
            hands.control(control["name"]).focus()
            for _ in range(11):
                hands.page.keyboard.press("Enter")
            for _ in range(11):
                hands.do("press", control["name"])
            hands.assert_alike(f"eleven presses of {control['name']}")


def test_what_is_done_fast_is_done_in_its_order(explorers):
    """A slider moved after a press has no say in what was pressed."""
    for hands in explorers[1]:
        slider, button = (controls_of(hands, kind)[:1] for kind in ("slider", "button"))
        if not slider or not button or button[0]["idle"]:
            continue
        (slider,), (button,) = slider, button
        place, press = hands.control(slider["name"]), hands.control(button["name"])
        # All in one go of the browser, so that the kernel answers none of them in between.
        place.evaluate(
            """(slider, button) => {
                const put = (at) => { slider.value = at; slider.dispatchEvent(new Event("input", { bubbles: true })); };
                for (const at of [0, 1, 2]) put(at);
                button.click();
                for (const at of [2, 1]) put(at);
            }""",
            press.element_handle(),
        )
        for what in (("turn", 0), ("turn", 2), ("press",), ("turn", 1)):
            name = button["name"] if what[0] == "press" else slider["name"]
            hands.do(what[0], name, *what[1:])
        hands.assert_alike("a press between moves")


def test_a_key_held_down_does_not_queue_up(explorers):
    for hands in explorers[1]:
        for board in hands.board.all():
            asked = """(board, key) => {
                for (let i = 0; i < 50; i++)
                    board.dispatchEvent(new KeyboardEvent("keydown", { key, repeat: i > 0, bubbles: true }));
            }"""
            board.evaluate(asked, "ArrowRight")
            hands.do("arrow", "ArrowRight")
            hands.assert_alike("a key held down while the kernel was busy")


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
        sliders = [hands.control(control["name"]) for control in controls_of(hands, "slider")[:1]]
        for place in sliders:
            last_put(place)
        for place in [*hands.board.all(), *sliders]:
            place.focus()
            for key in ARROWS:
                hands.page.keyboard.press(key)
                assert place.evaluate("node => node === document.activeElement"), f"{key} has taken the focus away"
        for _ in hands.board.all():
            for key in ARROWS:
                hands.do("arrow", key)
        for place in sliders:
            hands.do("turn", controls_of(hands, "slider")[0]["name"], last_put(place))
        hands.assert_alike("arrow keys")


def test_a_click_with_another_button_does_nothing(explorers):
    for hands in explorers[1]:
        for board in hands.board.all():
            before = hands.seen()
            board.locator('[data-cell="5"]').first.click(button="right", force=True)
            hands.page.keyboard.press("Escape")
            hands.page.wait_for_timeout(100)
            hands.wait()
            assert hands.seen() == before


def test_every_pattern_is_found_in_its_own_picture(explorers):
    """One in another picture fills nothing while that one is hidden."""
    for hands in explorers[1]:
        lost = hands.root.evaluate(
            """root => [...root.querySelectorAll('[fill^="url("]')].filter((shape) => {
                const pattern = document.getElementById(shape.getAttribute("fill").slice(5, -1));
                return !pattern || !shape.closest("svg").contains(pattern);
            }).length"""
        )
        assert lost == 0
    names = explorers[0].lab.page.evaluate(
        "[...document.querySelectorAll('.course-explorer [id]')].map((node) => node.id)"
    )
    assert len(set(names)) == len(names), "an id is given twice"


def test_the_browser_does_not_complain(explorers):
    assert explorers[0].complaints == []
    assert [error for cell in explorers[0].look()["cells"] for error in cell["errors"] + cell["warnings"]] == []


def test_controls_that_come_and_go_leave_the_focus_where_it_is(explorers):
    for hands in explorers[1]:
        for control in controls_of(hands, "choice"):
            for _ in control["texts"]:
                at = (hands.twin.state.view().control(control["name"]).at + 1) % len(control["texts"])
                place = hands.control(control["name"])
                place.focus()
                place.select_option(index=at)
                hands.do("turn", control["name"], at)
                hands.assert_alike(control["name"])
                assert place.evaluate("node => node === document.activeElement"), control["name"]


def test_a_kernel_that_is_gone_is_told(explorers):
    """Last, since it ends the kernel."""
    notebook, all_hands = explorers
    if "00" not in notebook.name:
        pytest.skip("it is the widget that tells it, and there is one for all")
    hands = all_hands[0]
    notebook.lab.page.evaluate("void window.jupyterapp.commands.execute('kernelmenu:restart')")
    notebook.lab.page.locator(".jp-Dialog .jp-mod-accept").click()
    hands.page.locator(".jp-Dialog").wait_for(state="detached")
    hands.page.wait_for_timeout(3000)  # the old kernel may still say that it is idle
    notebook.wait_for_kernel()
    name, press = next((one["name"], one["kind"]) for one in hands.twin.controls if not one.get("idle"))
    hands.control(name).focus()
    hands.page.keyboard.press(KEY_OF[press])
    hands.page.wait_for_function(
        "number => document.querySelectorAll('.ce-message')[number].textContent.startsWith('No answer from Python')",
        arg=hands.number,
        timeout=20_000,
    )
