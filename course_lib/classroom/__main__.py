"""The class on the command line: python -m course_lib.classroom COMMAND; `--help` names them."""

import argparse
import sys

from course_lib.classroom import templates


def main(arguments=None):
    """Do what the command line says; the exit code is 0, 1 for what cannot be done, 2 for what is not understood."""
    options = _parser().parse_args(arguments)
    try:
        return options.run(options) or 0
    except KeyboardInterrupt:
        print("stopped; what was graded so far is kept", file=sys.stderr)
    except (ImportError, OSError, ValueError, RuntimeError) as error:
        print(f"error: {error}", file=sys.stderr)
    return 1


def _parser():
    parser = argparse.ArgumentParser(
        prog="python -m course_lib.classroom",
        description="Give out homework, grade it, give it back. Work is handed in as "
        "submitted/LEARNER/HOMEWORK/NOTEBOOK.ipynb in the folder of the class; an optional roster.csv with a column "
        "'learner' says who should have.",
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    def command(name, run, words):
        added = commands.add_parser(name, help=words, description=f"{words[0].upper()}{words[1:]}.")
        added.set_defaults(run=run)
        return added

    def for_class(name, run, words, *, homework=True):
        added = command(name, run, words)
        if homework:
            added.add_argument("homework", help="such as homework_1")
        added.add_argument("--folder", default=".", help="folder of the class (default: this one)")
        return added

    new = command("new", _new, "make the folder of a class")
    new.add_argument("folder", help="a folder that is new or empty")
    new.add_argument("--exchange", metavar="FOLDER", help="where learners of this machine fetch and submit")
    release = for_class("release", _release, "make the notebook that learners get")
    release.add_argument("--exchange", action="store_true", help="also let learners fetch it")
    for_class("collect", _collect, "bring in what learners submitted on the exchange")
    autograde = for_class("autograde", _autograde, "grade what was handed in, and show the scores")
    autograde.add_argument("--learner", action="append", help="only this one (may be given several times)")
    feedback = for_class("feedback", _feedback, "write a page for every learner")
    feedback.add_argument("--exchange", action="store_true", help="also let every learner fetch their own")
    grades = for_class("grades", _grades, "show all scores", homework=False)
    grades.add_argument("--csv", metavar="FILE", help="also write them to FILE")
    template = command("template", _template, "make a learner's notebook from its source, without a class")
    template.add_argument("source", help="the notebook with solutions")
    template.add_argument("target", help="the notebook to write")
    hub = command("hub", _hub, "make the folder of a JupyterHub with an exchange")
    hub.add_argument("folder", help="a folder that is new or empty, where all accounts may read")
    links = command("links", _links, "show links that open the lessons on Binder and on Colab")
    links.add_argument("repository", help="its public address, such as https://github.com/OWNER/REPOSITORY")
    links.add_argument("--commit", help="the commit or tag that they lead to (default: this clone's commit)")
    return parser


def _course(options):
    from course_lib.classroom.course import Course

    return Course(options.folder)


def _new(options):
    from course_lib.classroom.course import Course

    course = Course.new(options.folder, exchange=options.exchange)
    print(f"made {course.folder} with {', '.join(course.homeworks)}")


def _exchange(course):
    from course_lib.classroom.exchange import Exchange

    return Exchange(course)


def _release(options):
    course = _course(options)
    exchange = _exchange(course) if options.exchange else None
    print(course.release(options.homework))
    if exchange:
        print(exchange.publish(options.homework))


def _collect(options):
    learners, notes = _exchange(_course(options)).collect(options.homework)
    print(f"new work of {', '.join(learners)}" if learners else "no new work")
    for note in notes:
        print(note, file=sys.stderr)


def _autograde(options):
    grades = _course(options).autograde(options.homework, learners=options.learner, progress=sys.stderr.isatty())
    _show([grade.row() for grade in grades])


def _feedback(options):
    course = _course(options)
    exchange = _exchange(course) if options.exchange else None
    pages = course.feedback(options.homework)
    for path in pages.values():
        print(path)
    if not pages:
        raise ValueError(f"nothing of {options.homework} has been graded yet")
    if exchange:
        given = exchange.give_back(options.homework)
        print(f"given back to {len(given)} of {len(pages)}")
        if missing := sorted(set(pages) - set(given)):
            raise RuntimeError(f"not given back: {', '.join(missing)}; the remarks of `grades` say why")


def _grades(options):
    _show(_course(options).grades(options.csv))


def _template(options):
    templates.write_template(options.source, options.target)


def _hub(options):
    from course_lib.classroom.hub import new_hub

    folder = new_hub(options.folder)
    print(f"made {folder}; as root: jupyterhub -f {folder / 'jupyterhub_config.py'}")


def _links(options):
    from course_lib.classroom.links import links

    print(links(options.repository, options.commit))


def _show(rows):
    """Print rows as a table of scores, with the remarks on a line's end."""
    from course_lib.classroom.submissions import printable

    table = [("learner", "homework", "score", "remarks")]
    for row in rows:
        score = f"{row['score']:g} of {row['max_score']:g}"
        table.append((printable(row["learner"], 40), row["homework"], score, row["remarks"]))
    widths = [max(len(line[column]) for line in table) for column in range(3)]
    for line in table:
        cells = [cell.ljust(width) for cell, width in zip(line, widths, strict=False)]
        print("  ".join([*cells, line[3]]).rstrip())


if __name__ == "__main__":
    sys.exit(main())
