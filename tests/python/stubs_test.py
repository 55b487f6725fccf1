"""The type hints speak of the module that there is: the same names, the same arguments."""

import ast
import importlib.machinery
import importlib.util
import inspect
import os
import re
import sys
import unittest

import elastin

STUB = os.path.join(os.path.dirname(elastin.__file__), "__init__.pyi")


def arguments_in_stub(function):
    plain = function.args
    names = [argument.arg for argument in plain.args + plain.kwonlyargs if argument.arg not in ("self", "cls")]
    return names + [f"**{plain.kwarg.arg}"] if plain.kwarg else names


def arguments_in_module(function):
    """Of a function of Python by its signature, of one of C++ by the first line of its doc string."""
    if inspect.isfunction(function) or hasattr(function, "__signature__"):
        names = [("**" if parameter.kind is parameter.VAR_KEYWORD else "") + name
                 for name, parameter in inspect.signature(function).parameters.items()]
        return [name for name in names if name not in ("self", "result", "simulation", "body")]
    signature = function.__doc__.splitlines()[0]
    return [name for name in re.findall(r"[(,] ?(\w+(?=:)|\*\*\w+)", signature) if name != "self"]


class Stubs(unittest.TestCase):
    def setUp(self):
        with open(STUB, encoding="utf8") as stream:
            tree = ast.parse(stream.read())
        self.functions = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}
        self.classes = {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}

    def test_names(self):
        self.assertEqual(sorted({*self.functions, *self.classes}), sorted(elastin.__all__))
        self.assertTrue(os.path.exists(os.path.join(os.path.dirname(STUB), "py.typed")))

    def test_words_are_the_modules(self):
        """Docstrings and experiments: `tools/stubs --write` puts them there."""
        path = os.path.join(os.environ["ELASTIN_SOURCE_DIR"], "tools/stubs")
        loader = importlib.machinery.SourceFileLoader("stubs", path)
        stubs = importlib.util.module_from_spec(importlib.util.spec_from_loader("stubs", loader))
        sys.dont_write_bytecode = True
        loader.exec_module(stubs)
        with open(STUB, encoding="utf8") as stream:
            text = stream.read()
        self.assertEqual(stubs.stub_of(elastin, text), text)

    def test_functions(self):
        for name, node in self.functions.items():
            with self.subTest(function=name):
                self.assertEqual(arguments_in_stub(node), arguments_in_module(getattr(elastin, name)))
                self.assertTrue(getattr(elastin, name).__doc__)

    def test_classes(self):
        for name, node in self.classes.items():
            functions = [item for item in node.body if isinstance(item, ast.FunctionDef)]
            setters = {item.name for item in functions if any(getattr(mark, "attr", "") == "setter" for mark in item.decorator_list)}
            in_stub = {item.name: item for item in reversed(functions)}  # a property's own before its setter
            in_module = getattr(elastin, name)
            self.assertTrue(in_module.__doc__ or name == "InputError", name)
            own = [base for base in in_module.__mro__ if base.__module__.startswith("elastin")
                   and (base is in_module or base.__name__ not in self.classes)]
            public = {one for base in own for one in vars(base) if not one.startswith("_")}
            hinted = {one for one in in_stub if not one.startswith("__")}
            above = [base.id for base in node.bases if isinstance(base, ast.Name) and base.id in self.classes]
            data = {item.target.id for parent in (name, *above) for item in self.classes[parent].body
                    if isinstance(item, ast.AnnAssign)}
            public -= data
            with self.subTest(cls=name):
                self.assertEqual(hinted, public)
            for method, item in in_stub.items():
                with self.subTest(cls=name, method=method):
                    found = inspect.getattr_static(in_module, method)
                    is_property = any(getattr(mark, "id", "") == "property" for mark in item.decorator_list)
                    self.assertEqual(isinstance(found, property), is_property)
                    if is_property:
                        self.assertEqual(found.fset is not None, method in setters)
                    if not is_property and method in (*hinted, "__init__"):
                        described = in_module if "__signature__" in vars(in_module) else getattr(in_module, method)
                        self.assertEqual(arguments_in_stub(item), arguments_in_module(described))


if __name__ == "__main__":
    unittest.main()
