"""The chapters of the course as notebooks, which ``python tools/write_course.py`` writes."""
