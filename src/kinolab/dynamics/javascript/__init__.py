"""JavaScript code generation: a machine's compiled expressions, for simulation in web pages.

The text that ``javascript_of`` returns is self-contained: it needs a JavaScript engine, but no
library, other file or network.
"""

from kinolab.dynamics.javascript.module import javascript_of

__all__ = ["javascript_of"]
