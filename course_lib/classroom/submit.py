"""nbgrader's `submit` in the learners' servers of a hub."""

import os

from nbgrader.exchange.default import ExchangeSubmit


class SubmitPrivately(ExchangeSubmit):
    """nbgrader's `submit`, which leaves open to all accounts what it hands in, behind a name that cannot be guessed.

    Here the folder is closed as well, but to its owner and to the teacher's group, which it has from `inbound`.
    """

    def copy_files(self):
        """Hand in, and close the folder."""
        super().copy_files()
        os.chmod(os.path.join(self.inbound_path, self.assignment_filename), 0o770)
