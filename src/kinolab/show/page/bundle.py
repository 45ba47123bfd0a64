"""Bundle the page's ES modules into one script, as a file from disk cannot import others."""

from __future__ import annotations

import re
from collections.abc import Mapping

IMPORT = re.compile(r'^import \{([^}]*)\} from "\.{1,2}/(?:\w+/)?(\w+)\.js";\n', re.MULTILINE)
EXPORT = re.compile(r"^export (?:async )?(?:function|const|class) (\w+)", re.MULTILINE)


def bundle(modules: Mapping[str, str], main: str) -> str:
    """Return a script in which every module is a function that returns its exports.

    A module imports only ``{ names }`` from ``"./other.js"``, in whatever folder that lies, at the
    beginning of lines, and exports only functions, constants and classes where they are declared.

    Args:
        modules: Module sources by name.

    Raises:
        ValueError: If a module is missing, imports are circular, or a name is not exported.
    """
    parts = [_wrapped(name, modules) for name in _ordered(modules, main)]
    return "\n".join(['"use strict";', *parts])


def _ordered(modules: Mapping[str, str], main: str) -> list[str]:
    """Return the required modules in topological order of imports."""
    done: list[str] = []

    def visit(name: str, path: tuple[str, ...]) -> None:
        if name in path:
            raise ValueError(f"imports go round in a circle: {' -> '.join([*path, name])}")
        if name not in modules:
            raise ValueError(
                f"{path[-1] if path else 'the page'} needs {name}.js, which is missing"
            )
        for _, other in IMPORT.findall(modules[name]):
            if other not in done:
                visit(other, (*path, name))
        done.append(name)

    visit(main, ())
    return done


def _wrapped(name: str, modules: Mapping[str, str]) -> str:
    """Return a module as an immediately invoked function."""
    source = modules[name]
    for names, other in IMPORT.findall(source):
        offered = EXPORT.findall(modules[other])
        for wanted in names.split(","):
            if wanted.strip() and wanted.strip() not in offered:
                raise ValueError(f"{name}.js imports {wanted.strip()}; {other}.js has no such name")
    body = IMPORT.sub(lambda found: f"const {{{found[1]}}} = module_{found[2]};\n", source)
    given = ", ".join(EXPORT.findall(source))
    body = re.sub(r"^export ", "", body, flags=re.MULTILINE)
    return f"const module_{name} = (() => {{\n{body}\nreturn {{ {given} }};\n}})();"
