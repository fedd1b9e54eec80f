# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes docstrings.h: the docstrings and signatures of arap_native/__init__.pyi, for the compiled objects.

The stub is the one place where the Python interface is described.

Usage: docstrings.py STUB HEADER
"""

import ast
import inspect
import sys
from collections.abc import Iterator
from pathlib import Path


def signature(function: ast.FunctionDef) -> str:
    """Returns the line that makes inspect.signature() and help() work for a compiled function."""
    arguments = function.args
    for argument in (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs):
        argument.annotation = None
    return f"{function.name}({ast.unparse(arguments)})\n--\n\n"


def class_docstrings(class_: ast.ClassDef) -> Iterator[tuple[str, str]]:
    """Yields (name, text) of a class, its methods, properties and described attributes."""
    yield class_.name, ast.get_docstring(class_) or ""
    for member, following in zip(class_.body, [*class_.body[1:], None], strict=True):
        if isinstance(member, ast.FunctionDef):
            text = ast.get_docstring(member) or ""
            is_property = any(ast.unparse(decorator) == "property" for decorator in member.decorator_list)
            yield f"{class_.name}_{member.name.strip('_')}", text if is_property else signature(member) + text
        elif isinstance(member, ast.AnnAssign) and isinstance(member.target, ast.Name):
            match following:
                case ast.Expr(value=ast.Constant(value=str(text))):
                    yield f"{class_.name}_{member.target.id}", inspect.cleandoc(text)


def docstrings(stub: ast.Module) -> Iterator[tuple[str, str]]:
    """Yields (name, text) of the module and of everything in it."""
    yield "module", ast.get_docstring(stub) or ""
    for statement in stub.body:
        if isinstance(statement, ast.ClassDef):
            yield from class_docstrings(statement)
        elif isinstance(statement, ast.FunctionDef):
            yield statement.name, signature(statement) + (ast.get_docstring(statement) or "")


def main() -> None:
    """Writes the header, and leaves it alone where nothing changed, so that nothing is compiled again."""
    stub_file, header_file = (Path(argument) for argument in sys.argv[1:])
    stub = ast.parse(stub_file.read_text(encoding="utf-8"))
    constants = [f'inline constexpr char {name}[] = R"doc({text})doc";\n' for name, text in docstrings(stub)]
    header = "".join(
        [
            "// SPDX-License-Identifier: GPL-3.0-or-later\n",
            f"// Made by {Path(__file__).name} from {stub_file.name}: change that.\n",
            "#pragma once\n\nnamespace docstrings {\n\n",
            "// NOLINTBEGIN(readability-identifier-naming): the names are Python's.\n",
            *constants,
            "// NOLINTEND(readability-identifier-naming)\n\n}  // namespace docstrings\n",
        ]
    )
    if not header_file.exists() or header_file.read_text(encoding="utf-8") != header:
        header_file.write_text(header, encoding="utf-8")


if __name__ == "__main__":
    main()
