"""Numbers as all explorers write them, in pictures, tables and messages: with a true minus sign."""

from course_lib.plots import board

_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def numeral(number, form="g"):
    """A number in a format of Python's, its hyphen replaced by a minus sign."""
    return with_minus(format(number, form))


def signed(number):
    """Such as +1 and −3."""
    return numeral(number, "+g")


def two_places(number):
    """Two digits behind the point."""
    return numeral(number, "z.2f")


def short(number):
    """Three digits, of which at most three behind the point; whole numbers from a thousand up."""
    written = board.short(number)
    return "0" if written == "-0" else with_minus(written)


def power_of_ten(exponent):
    """10⁴ and the like; exponent: a whole number."""
    return "10" + str(exponent).translate(_RAISED)


def scientific(number, form=".1e"):
    """7.2×10¹⁰ and the like; form: a format with an exponent."""
    digits, exponent = format(number, form).split("e")
    return f"{with_minus(digits)}×{power_of_ten(int(exponent))}"


def with_minus(written):
    """A number that is written already."""
    return written.replace("-", "−")
