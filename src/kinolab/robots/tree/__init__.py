"""The tree of links that every format describes, with its loops, and what is wrong with it."""
