"""A class as its teacher has it, which needs nbgrader, and what learners may hand in to it."""
