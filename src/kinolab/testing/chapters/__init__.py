"""The exercises of each chapter of the course, with what is right in closed form."""
