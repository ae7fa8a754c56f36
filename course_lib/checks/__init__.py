"""What tells a learner right from wrong: one module a homework, over one small machinery.

from course_lib.checks import homework_1 as checks
checks.goes_on_after_a_bump(play_on)      # shows a Verdict
checks.goes_on_after_a_bump.hint()        # the next of several hints
"""
