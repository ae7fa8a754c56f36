"""A class on a real JupyterHub: all work is graded once, none is lost, and nobody sees another's or the teacher's."""

import csv
import json
import os
from pathlib import Path

import pytest
import requests

from .school import (
    ANSWERS,
    CLASS,
    INBOUND,
    KILLED,
    LINKING,
    MISCHIEVOUS,
    NAMES,
    REAL,
    REAL_ANSWERS,
    SECRET,
    SHARED,
    SMALL,
)

VICTIM = "learner-00"
HOME = Path("/home", VICTIM)
NOTEBOOK = f"{SMALL}/{NAMES[SMALL]}"

# Each is an expression in a learner's kernel, with `path` the file or folder that it is about.
READ = "open(path, 'rb').read(1)"
LIST, REMOVE, WRITE = "os.listdir(path)", "os.rename(path, path + '-gone')", "open(path, 'ab').write(b'x')"


@pytest.fixture(scope="module")
def grades(school):
    """{(learner, homework): row} of the teacher's table."""
    assert school
    with (CLASS / "grades.csv").open(encoding="utf-8-sig", newline="") as file:
        rows = list(csv.DictReader(file))
    table = {(row["learner"], row["homework"]): row for row in rows}
    assert len(table) == len(rows), "a row for each"
    return table


def page(learner, homework):
    """Their feedback page as their own server shows it; None where there is none."""
    folder = f"{homework}/feedback"
    if learner.ask("GET", f"api/contents/{folder}").status_code == 404:
        return None
    (taken,) = learner.read(folder)
    return learner.read(f"{taken['path']}/{Path(NAMES[homework]).stem}.html")


def test_at_least_eight_servers_were_up_at_once(school):
    assert school.seen["servers"] == set(school.learners)
    assert len(school.seen["servers"]) >= min(8, len(school.learners))


def test_how_long_it_took(school, record_testsuite_property):
    for name, seconds in school.seconds.items():
        record_testsuite_property(name, round(seconds, 1))
        print(f"{name}: {seconds:.1f} s")
    for homework, number in ((SMALL, len(school.kinds)), (REAL, len(REAL_ANSWERS))):
        seconds = school.seconds[f"grade {homework}"] / number
        record_testsuite_property(f"seconds to grade a submission of {homework}", round(seconds, 2))
        print(f"{number} submissions of {homework}: {seconds:.2f} s each to grade")


def test_every_submission_is_graded_and_none_is_lost(school, grades):
    for name, kind in school.kinds.items():
        row = grades[name, SMALL]
        expected = 0 if name == LINKING else ANSWERS[kind][1]
        assert float(row["task_1"]) == float(row["score"]) == expected, (name, kind, row)
        assert "Nothing handed in" not in row["remarks"], name
    assert {learner for learner, homework in grades if homework == SMALL} == set(school.kinds)


def test_homework_1_for_real(school, grades):
    for name, wrong in REAL_ANSWERS.items():
        row = grades[name, REAL]
        assert (row["score"] == row["max_score"]) == (wrong is None), row
        assert float(row["task_1_check"]) > 0, row
        assert "Task 1" in page(school.learners[name], REAL)


def test_everybody_fetches_their_own_page(school):
    for name, text in school.together(lambda learner: page(learner, SMALL)).items():
        if name == LINKING:
            assert text is None, "it was not submitted from a server, which would know the way back"
            continue
        points = float(ANSWERS[school.kinds[name]][1])
        assert f"(Score: {points} / 4.0)" in text, name
        assert SECRET not in text, "the hidden test"


def test_a_killed_server_costs_nobody_anything(school, grades):
    dead, others = school.seen["while it was dead"]
    assert dead in (424, 503)
    assert others["cells"]
    before, after = school.seen["saved before and after"]
    assert before == after
    assert school.kinds[KILLED] == "right"
    assert float(grades[KILLED, SMALL]["score"]) == 4


def test_mischief_is_noted_and_costs_nobody_anything(school, grades):
    said = school.seen["collected"]
    assert (
        f"learner-00+small+2099-01-01 00:00:00.000000 UTC+x is not collected: it was put there by {MISCHIEVOUS}" in said
    )
    for name in ("learner-03+small+never+x", "x+small+y", "+small+", "it is no folder"):
        assert name in said
    assert school.kinds["learner-00"] == "right"
    assert float(grades["learner-00", SMALL]["score"]) == 4
    assert {path.name for path in (CLASS / "submitted").iterdir()} == set(school.kinds)


def test_links_lead_nowhere(school, grades):
    collected = CLASS / "submitted" / LINKING / SMALL
    assert sorted(path.name for path in collected.iterdir()) == ["submission_secret.txt", "timestamp.txt"]
    assert "small.ipynb is a link or not its owner's" in school.seen["collected"]
    assert float(grades[LINKING, SMALL]["score"]) == 0
    for path in (CLASS / "feedback" / LINKING).rglob("*.html"):
        assert "return 2 * number" not in path.read_text()


def test_collected_again_there_is_nothing_new(school):
    assert school.teacher("collect", SMALL).startswith("no new work")


def test_work_on_the_exchange_stays_until_the_teacher_removes_it(school):
    owners = [path.owner() for path in INBOUND.iterdir() if f"+{SMALL}+" in path.name and not path.is_symlink()]
    assert set(owners) == set(school.kinds)


def test_released_again_the_new_one_is_fetched(school):
    learner = school.learners[MISCHIEVOUS]
    outbound = INBOUND.parent / "outbound" / SMALL / NAMES[SMALL]
    before = outbound.stat().st_mtime_ns
    school.teacher("release", SMALL, "--exchange")
    assert outbound.stat().st_mtime_ns > before
    assert learner.assignments("demo")


# --- what a learner sees and may do in their own server ---------------------------------------------------------------


@pytest.fixture(scope="module")
def attempts(school):
    """{(what, path): the name of the error that it met, or what it gave}, all tried in the learner's own kernel."""
    (theirs,) = (
        path
        for path in INBOUND.iterdir()
        if path.name.startswith(f"{VICTIM}+{SMALL}+") and not path.is_symlink() and path.owner() == VICTIM
    )
    process = school.learners[VICTIM].server_process()
    tries = [
        (LIST, INBOUND),
        (LIST, theirs),
        (READ, theirs / NAMES[SMALL]),
        (READ, theirs / "submission_secret.txt"),
        (WRITE, theirs / NAMES[SMALL]),
        (REMOVE, theirs),
        (LIST, HOME),
        (READ, HOME / NOTEBOOK),
        (LIST, HOME / ".local/share/jupyter/nbgrader_cache"),
        (LIST, HOME / ".run"),
        (READ, f"/proc/{process}/environ"),
        (LIST, f"/proc/{process}/cwd"),
        (LIST, CLASS),
        (READ, CLASS / "source" / SMALL / NAMES[SMALL]),
        (READ, CLASS / "gradebook.db"),
        (READ, CLASS / "grades.csv"),
        (READ, CLASS / "nbgrader_config.py"),
        (READ, CLASS / "submitted" / VICTIM / SMALL / NAMES[SMALL]),
        (READ, CLASS / "checked" / VICTIM / SMALL / NAMES[SMALL]),
        (READ, CLASS / "autograded" / VICTIM / SMALL / NAMES[SMALL]),
        (READ, CLASS / "feedback" / VICTIM / SMALL / "small.html"),
        (LIST, INBOUND.parent / "feedback"),
        (REMOVE, INBOUND.parent),
        (REMOVE, INBOUND),
        (WRITE, INBOUND.parent / "outbound" / SMALL / NAMES[SMALL]),
        (WRITE, INBOUND.parent / "feedback" / "new.html"),
        (LIST, SHARED / "state"),
        (READ, SHARED / "state" / "jupyterhub.sqlite"),
        (READ, SHARED / "state" / "cookie_secret"),
        (WRITE, SHARED / "jupyterhub_config.py"),
        (WRITE, SHARED / "jupyter" / "nbgrader_config.py"),
        (READ, "/etc/shadow"),
    ]
    for what, path in tries:
        assert what != READ or os.path.exists(path), f"{path} is there to be read"
    code = "import json, os\nsaid = []\n" + "\n".join(
        f"path = {str(path)!r}\ntry: said += [repr({what})]\nexcept OSError as error: said += [type(error).__name__]"
        for what, path in tries
    )
    said = json.loads(school.learners[MISCHIEVOUS].run(f"{code}\nprint(json.dumps(said))"))
    return {(what, str(path)): answer for (what, path), answer in zip(tries, said, strict=True)}


def test_every_attempt_is_refused(attempts):
    assert len(attempts) >= 30
    assert {attempt: answer for attempt, answer in attempts.items() if answer != "PermissionError"} == {}


def test_what_is_open_is_what_should_be(school):
    """Without this, a kernel that can read nothing at all would pass the test above."""
    code = f"import os; print(os.listdir({str(INBOUND.parent / 'outbound')!r}), os.path.exists({NOTEBOOK!r}))"
    assert sorted(NAMES) == sorted(eval(school.learners[MISCHIEVOUS].run(code).rpartition(" ")[0]))


def test_no_file_that_a_learner_can_read_holds_a_hidden_test(school):
    code = f"""
import os
found, read = [], 0
for top in ("/home", "/srv", "/var/tmp", "/dev/shm"):
    for place, _, files in os.walk(top):
        for name in files:
            try:
                with open(os.path.join(place, name), "rb") as file:
                    content, read = file.read(), read + 1
            except OSError:
                continue
            if b"{SECRET[:6]}" b"{SECRET[6:]}" in content:
                found.append(os.path.join(place, name))
print(read > 10, found)
"""
    assert school.learners[MISCHIEVOUS].run(code) == "True []\n"


def test_another_ones_server_does_not_answer(school):
    nosy = school.learners[MISCHIEVOUS]
    assert nosy.ask("GET", f"api/contents/{NOTEBOOK}").status_code == 200
    for path in (f"api/contents/{NOTEBOOK}", "api/kernels", "api/terminals", "assignments?course_id=demo"):
        assert nosy.ask("GET", path, of=VICTIM).status_code == 403, path


def test_not_even_at_its_own_port(school):
    """Past the hub's proxy, as from a terminal of the same machine."""
    code = f"""
import os, urllib.request, urllib.error
lines = [line.split() for line in open("/proc/net/tcp").readlines()[1:]]
ports = [line[1].split(":")[1] for line in lines if line[3] == "0A" and int(line[7]) == {HOME.stat().st_uid}]
print(len(ports))
for port in ports:
    address = f"http://127.0.0.1:{{int(port, 16)}}/user/{VICTIM}/api/contents/{NOTEBOOK}"
    for headers in ({{}}, {{"Authorization": "token " + os.environ["JUPYTERHUB_API_TOKEN"]}}):
        try:
            print(urllib.request.urlopen(urllib.request.Request(address, headers=headers), timeout=30).status)
        except urllib.error.HTTPError as error:
            print(error.code)
"""
    assert school.learners[MISCHIEVOUS].run(code).split() == ["1", "403", "403"]


def test_kernels_do_not_speak_where_others_could_listen(school):
    """Over TCP any account could subscribe to what is run in a kernel and what comes out, which is not encrypted."""
    victim = school.learners[VICTIM]
    kernel = victim.asked("POST", "api/kernels", json={"name": "python3"})["id"]
    try:
        told = json.loads((HOME / ".run" / f"kernel-{kernel}.json").read_text())
    finally:
        victim.asked("DELETE", f"api/kernels/{kernel}")
    assert told["transport"] == "ipc"
    assert told["ip"].startswith(f"{HOME}/.run/")


def test_a_page_is_found_by_its_own_learner_only(school):
    """What protects it is the secret of the submission, which the page's name is made of."""
    pages = list((INBOUND.parent / "feedback").iterdir())
    assert len({page.name for page in pages}) >= len(school.kinds) - 1
    for page in pages:
        assert len(page.stem) == 32
        assert page.stat().st_mode & 0o777 == 0o644
    assert (INBOUND.parent / "feedback").stat().st_mode & 0o777 == 0o711


def test_only_accounts_in_the_group_come_in_and_only_with_their_password(school):
    def log_in(name, password):
        with requests.Session() as browser:
            page = browser.get(f"{school.hub.address}/hub/login", timeout=30)
            form = {"username": name, "password": password, "_xsrf": browser.cookies["_xsrf"]}
            return browser.post(page.url, data=form, timeout=60).status_code

    assert log_in(VICTIM, f"word of {VICTIM}") == 200
    assert log_in(VICTIM, "a guess") == 403
    assert log_in("teacher", "a guess") == 403
