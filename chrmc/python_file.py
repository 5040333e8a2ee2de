"""Scenes and methods of your own on the command line: FILE.py:NAME."""

import hashlib
import importlib.util
import inspect
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, TypeGuard

from chrmc.ranges import short

MODULE_PREFIX = "chrmc_python_file_"
"""Names of the modules that such files become."""


def is_python_name(text: Any) -> TypeGuard[str]:
    """Whether a text has the form FILE.py:NAME."""
    if not isinstance(text, str):
        return False
    file, colon, name = text.rpartition(":")
    return bool(colon) and file.lower().endswith(".py") and name.isidentifier()


def from_python_file(text: str) -> Any:
    """What FILE.py:NAME names; ValueError or OSError in one line where that fails.

    The file is run once for its content. Its folder joins the end of the module search path, so
    that it can import its neighbours.
    """
    file, _, name = text.rpartition(":")
    path = Path(file)
    try:
        content = path.read_bytes()
    except IsADirectoryError:
        raise FileNotFoundError(f"{path} is a folder, not a Python file") from None
    except FileNotFoundError:
        raise FileNotFoundError(f"there is no Python file {path}") from None
    path = path.resolve()
    key = hashlib.sha256(str(path).encode() + content).hexdigest()[:16]
    module_name = MODULE_PREFIX + key
    module = sys.modules.get(module_name)
    if module is None:
        spec = importlib.util.spec_from_file_location(module_name, path)
        assert spec is not None
        module = importlib.util.module_from_spec(spec)
        if str(path.parent) not in sys.path:
            sys.path.append(str(path.parent))
        sys.modules[module_name] = module
        try:
            with one_line(text):
                # Not through Python's cache, which takes two versions of one second for one.
                exec(compile(content, str(path), "exec", dont_inherit=True), vars(module))
        except BaseException:
            del sys.modules[module_name]
            raise
    if not hasattr(module, name):
        own = [n for n in vars(module) if not n.startswith("_")]
        raise ValueError(f"{path} has no {name!r}; it has {', '.join(own) or 'nothing'}")
    return getattr(module, name)


def function_from_python_file(text: str) -> Callable[..., Any]:
    """The function that FILE.py:NAME names; ValueError for anything else of that name."""
    found = from_python_file(text)
    if not callable(found):
        raise ValueError(f"{text} is no function, but a {type(found).__name__}")
    function: Callable[..., Any] = found
    return function


@contextmanager
def one_line(*names: Any) -> Iterator[None]:
    """An error in the code of FILE.py:NAME as a ValueError of one line with file and line; other
    errors, and other names, pass as they are."""
    files = {Path(name.rpartition(":")[0]).resolve() for name in names if is_python_name(name)}
    try:
        yield
    except (ValueError, OSError):
        raise
    except Exception as error:
        if isinstance(error, SyntaxError) and error.filename is not None:
            places = [(error.filename, error.lineno)]
        else:
            places = [(f.filename, f.lineno) for f in traceback.extract_tb(error.__traceback__)]
        for filename, line in reversed(places):
            if Path(filename) in files:
                reason = " ".join(f"{type(error).__name__}: {error}".split())
                raise ValueError(f"{filename}, line {line}: {reason}") from error
        raise


def identity(method: Any) -> Any:
    """What a manifest says of a method: its name; file, function and hash for FILE.py:NAME; a
    function's qualified name and, where its source is a file, that file's hash."""
    if is_python_name(method):
        file, _, name = method.rpartition(":")
        return {"file": Path(file).name, "function": name, "sha256": _hash(Path(file))}
    if not callable(method):
        return method
    module = getattr(method, "__module__", type(method).__module__)
    name = getattr(method, "__qualname__", type(method).__qualname__)
    entry = {"function": f"{module}.{name}"}
    with suppress(TypeError):
        source = inspect.getsourcefile(method)
        if source is not None and Path(source).is_file():
            entry["sha256"] = _hash(Path(source))
    return entry


def label(method: Any) -> str:
    """A method's name for messages, from the method or from what `identity` says of it."""
    if isinstance(method, str):
        return method
    entry = method if isinstance(method, dict) else identity(method)
    if not isinstance(entry, dict):
        return short(entry)
    file = f"{entry['file']}:" if "file" in entry else ""
    return f"{file}{entry.get('function', 'unknown')}"


def _hash(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
