"""Text for LLVM -> machine code, kept on disk for the next process, and its functions' addresses.

The object files lie in the cache of derived results, whose files are read only where the user alone can have written them.
"""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import version
from inspect import getsource, isfunction
from types import ModuleType
from typing import Any, cast, get_type_hints

import llvmlite.binding as llvm
import numpy as np

from wucht.disk_cache import derived_once
from wucht.function_call import CALL_PREFIX
from wucht.numerics.flow.compiled.kernel_translation import INSTRUCTIONS, kernel_text
from wucht.numerics.flow.compiled.straight_line_code import LIBRARY, LIBRARY_PREFIX

_OPTIMISATION = 2  # the third level takes much longer and gains nothing measurable


@dataclass(frozen=True)
class MachineCode:
    """Machine code in this process: the addresses of functions, valid as long as it lives."""

    addresses: dict[str, int]
    _engine: Any = field(repr=False)

    @classmethod
    def of(cls, text: str, names: tuple[str, ...]) -> MachineCode:
        """Compile a module, or read what an earlier process made of it."""
        is_of_this_process = CALL_PREFIX in text
        content = compiled_object(text, names) if is_of_this_process else object_file(text, names, target_description())
        return cls.of_file(content, names)

    @classmethod
    def of_file(cls, content: bytes, names: tuple[str, ...]) -> MachineCode:
        """Load an object file."""
        _register_library()
        engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), _target_machine())
        engine.add_object_file(llvm.ObjectFileRef.from_data(content))
        engine.finalize_object()
        return cls({name: engine.get_function_address(name) for name in names}, engine)


@cache
def compile_stepper(function: Callable[[Any], int], width: int = 1) -> Callable[..., int]:
    """Compile a function of records of memory with its module, or read what an earlier process made of it.

    What is returned does not hold the interpreter's lock; its arguments are the fields of the records: numbers, else addresses.
    width: of vectors.
    """
    name, (*records, _) = function.__name__, get_type_hints(function).values()
    modules = _modules_of(function.__module__, *(record.__module__ for record in records))
    text = "".join(map(getsource, modules))
    code = MachineCode.of_file(_stepper_file(text, name, _numbers_of(modules), width, target_description()), (name,))
    kinds: dict[type, Any] = {int: ctypes.c_int64, float: ctypes.c_double}
    arguments = [kinds.get(kind, ctypes.c_void_p) for record in records for kind in get_type_hints(record).values()]
    machine_code: Any = ctypes.CFUNCTYPE(ctypes.c_int64, *arguments)(code.addresses[name])
    machine_code.code = code  # which must live as long
    return cast(Callable[..., int], machine_code)


def _numbers_of(modules: list[ModuleType]) -> tuple[tuple[str, float], ...]:
    """Return the numbers that have names in modules. Raises ``TypeError`` where two modules differ."""
    numbers = dict[str, float]()
    for module in modules:
        for name, value in vars(module).items():
            if isinstance(value, int | float) and numbers.setdefault(name, value) != value:
                raise TypeError(f"two modules of one stepper have different numbers of the name {name}")
    return tuple(numbers.items())


def _modules_of(*names: str) -> list[ModuleType]:
    """Return the modules of these names, and those from which they import functions that are translated."""
    modules, pending = dict[str, ModuleType](), [*names]
    while pending:
        name = pending.pop()
        if name not in modules:
            modules[name] = sys.modules[name]
            functions = [v for key, v in vars(modules[name]).items() if isfunction(v) and key not in INSTRUCTIONS]
            pending += [v.__module__ for v in functions if v.__module__.startswith(f"{__package__}.")]
    return list(modules.values())


@derived_once
def _stepper_file(text: str, name: str, numbers: tuple[tuple[str, float], ...], width: int, target: tuple[str, ...]) -> bytes:
    """Compile a stepper from its text in Python to an object file. target: for which processor, by which LLVM."""
    return compiled_object(kernel_text(text, dict(numbers), width), (name,))


@derived_once
def object_file(text: str, names: tuple[str, ...], target: tuple[str, ...]) -> bytes:
    """Compile a module to an object file with the functions of these names. target: for which processor, by which LLVM."""
    return compiled_object(text, names)


def compiled_object(text: str, names: tuple[str, ...]) -> bytes:
    """Compile a module to an object file; names: of its functions that are called from outside."""
    module, machine = llvm.parse_assembly(text), _target_machine()
    for function in module.functions:
        if function.name not in names and not function.is_declaration:
            function.linkage = "internal"
    options = llvm.create_pipeline_tuning_options(_OPTIMISATION)
    options.loop_vectorization, options.slp_vectorization, options.loop_unrolling = True, True, False
    builder = llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)
    contents: list[bytes] = []
    engine = llvm.create_mcjit_compiler(module, machine)
    engine.set_object_cache(notify_func=lambda _module, content: contents.append(content))
    engine.finalize_object()
    return contents[0]


def target_description() -> tuple[str, ...]:
    """Describe what an object file depends on: LLVM and the processor."""
    _initialise()
    return version("llvmlite"), llvm.get_process_triple(), llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()


def _target_machine() -> Any:
    _, triple, processor, features = target_description()
    return llvm.Target.from_triple(triple).create_target_machine(processor, features, _OPTIMISATION, jit=True)


@cache
def _initialise() -> None:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()


@cache
def _register_library() -> None:
    """Tell LLVM where the C library's functions are."""
    library = ctypes.CDLL("ucrtbase" if sys.platform == "win32" else None)
    for name in LIBRARY:
        llvm.add_symbol(LIBRARY_PREFIX + name, ctypes.cast(getattr(library, name), ctypes.c_void_p).value)


def vectors(count: int, width: int) -> np.ndarray:
    """Return memory for so many vectors of so many numbers, zero, aligned as the processor reads them."""
    room = np.zeros((count + 1) * width)
    first = -(room.ctypes.data // room.itemsize) % width
    return room[first : first + count * width]
