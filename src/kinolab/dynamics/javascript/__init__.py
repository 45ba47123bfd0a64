"""Machines as JavaScript: the expressions that kinolab compiles, for a page to simulate with.

The text that ``javascript_of`` returns needs nothing but a JavaScript engine: no library, no file
beside it and no network.
"""

from kinolab.dynamics.javascript.module import javascript_of

__all__ = ["javascript_of"]
