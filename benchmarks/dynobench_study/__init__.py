"""The problems of dynobench, judged twice: by the authors' own code, and more strictly."""
