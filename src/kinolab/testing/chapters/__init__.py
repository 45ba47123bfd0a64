"""The exercises of each chapter of the course, with what is right in closed form."""

THREE_DIGITS = 5e-3  # of an answer's size: what rounding to three significant digits may change
