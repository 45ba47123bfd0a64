"""What compiled loops and functions on arrays are told in words: every argument, every shape."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator

import pytest

from tests.support import ROOT

KERNELS = {"kernel", "allocating_kernel", "compiled"}  # the decorators that compile
ARRAYS = {"Array", "ArrayLike", "Bytes", "Integers", "NDArray", "Singles"}
MAX_PLAIN_ARGUMENTS = 4  # that a kernel's first sentence can speak of
SHAPE = re.compile(r"\bshapes?\b|\([^()]*,[^()]*\)", re.IGNORECASE)  # in words, or such as (nx,)

FILES = sorted(
    file for folder in ("src/kinolab", "planners") for file in (ROOT / folder).rglob("*.py")
)


def functions(text: str) -> Iterator[ast.FunctionDef]:
    return (node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.FunctionDef))


def names_in(tree: ast.AST) -> set[str]:
    return {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}


def is_kernel(function: ast.FunctionDef) -> bool:
    return any(names_in(decorator) & KERNELS for decorator in function.decorator_list)


def parameters(function: ast.FunctionDef) -> list[ast.arg]:
    return [*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs]


def described(function: ast.FunctionDef) -> dict[str, str]:
    """What a docstring says below Args, by argument; several may share an entry."""
    below = (ast.get_docstring(function) or "").partition("\nArgs:\n")[2]
    section = re.split(r"\n\n|\n\S", below)[0]
    entries = re.findall(r"^    (\w[\w, ]*):((?:.*(?:\n     .*)*))", section, re.MULTILINE)
    return {name.strip(): text for names, text in entries for name in names.split(",")}


def arrays_of(function: ast.FunctionDef) -> set[str]:
    """The arguments of which a kernel itself takes entries."""
    return {
        node.value.id
        for node in ast.walk(function)
        if isinstance(node, ast.Subscript) and isinstance(node.value, ast.Name)
    } & {argument.arg for argument in parameters(function)}


def kernel_faults(text: str) -> Iterator[str]:
    """Yield what kernels of many arguments do not say of them."""
    for function in functions(text):
        if not is_kernel(function) or len(parameters(function)) <= MAX_PLAIN_ARGUMENTS:
            continue
        told, arrays = described(function), arrays_of(function)
        for argument in parameters(function):
            if argument.arg not in told:
                yield f"{function.name} says nothing of {argument.arg}"
            elif argument.arg in arrays and not SHAPE.search(told[argument.arg]):
                yield f"{function.name} does not say the shape of {argument.arg}"


def function_faults(text: str) -> Iterator[str]:
    """Yield the public functions at the top of a module that take or return arrays of no shape."""
    for function in ast.parse(text).body:
        if not isinstance(function, ast.FunctionDef) or function.name.startswith("_"):
            continue
        notes = [*(argument.annotation for argument in parameters(function)), function.returns]
        on_arrays = any(names_in(note) & ARRAYS for note in notes if note is not None)
        if on_arrays and not SHAPE.search(ast.get_docstring(function) or ""):
            yield f"{function.name} does not say the shape of its arrays"


def test_arguments_and_shapes_are_told() -> None:
    assert len(FILES) > 100
    texts = {str(file.relative_to(ROOT)): file.read_text(encoding="utf-8") for file in FILES}
    found = {name: [*kernel_faults(text), *function_faults(text)] for name, text in texts.items()}
    assert {name: faults for name, faults in found.items() if faults} == {}


DESCRIBED = '''
@kernel
def add(a, b, n, out, scratch):
    """Add two vectors.

    Args:
        a, b: Vectors, shape (n,).
        n: Their size.
        out: The sum, (n,);
            written.
        scratch: ``Scratch``.

    Returns:
        Nothing.
    """
    out[0] = a[0] + b[0]


def norm(x: Array) -> float:
    """Return the length of x, shape (n,)."""
'''
OMISSIONS = {
    "a, b: Vectors": ("a: Vectors", "add says nothing of b"),
    "        n: Their size.\n": ("", "add says nothing of n"),
    "The sum, (n,)": ("The sum", "add does not say the shape of out"),
    "Vectors, shape (n,)": ("Vectors", "add does not say the shape of a"),
    "Args:": ("Arguments:", "add says nothing of scratch"),
    "x, shape (n,)": ("x", "norm does not say the shape of its arrays"),
}


@pytest.mark.parametrize("words", OMISSIONS)
def test_what_is_left_out_is_noticed(words: str) -> None:
    assert [*kernel_faults(DESCRIBED), *function_faults(DESCRIBED)] == []
    less, fault = OMISSIONS[words]
    assert words in DESCRIBED
    short = DESCRIBED.replace(words, less)
    assert fault in [*kernel_faults(short), *function_faults(short)]
