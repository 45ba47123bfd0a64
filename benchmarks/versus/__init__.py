"""kinolab beside OMPL in C++: the parts of ``versus_ompl.py``, and the problems of both."""
