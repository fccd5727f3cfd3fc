"""Kerf: read a dental surface, make it a solid, cut it, get the mesh for the printer.

All lengths in mm, in the frame of the scan. Arrays are numpy; those of a mesh are views without a copy, read-only.
An error is a kerf.Error with the attributes code, file, place, found, expected and hint. Long calls release the
interpreter's lock and take progress(fraction, step). Ctrl-C ends bake soon, the others at their next
report of progress.

    m = kerf.read("arch.stl")
    c = kerf.bake(m, voxel=0.1, base="full")
    r = c.cut(kerf.tool("856-016"), path)
    r.mesh.write("cut.stl")
"""

from __future__ import annotations

import os

from . import _kerf
from ._kerf import Case, Check, Cut, Mesh


class Error(Exception):
    """A failure that a user can act on: str() is the sentence of the command line."""

    def __init__(self, message, code="", file="", place="", found="", expected="", hint=""):
        super().__init__(message)
        self.code, self.file, self.place = code, file, place
        self.found, self.expected, self.hint = found, expected, hint


_kerf.set_error(Error)


def _toml_value(value):
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, str):
        escaped = value.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
        return f'"{escaped}"'
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_toml_value(v) for v in value) + "]"
    raise TypeError(f"a tool file has no value of type {type(value).__name__}")


def _toml(table, name=""):
    lines = [f"{key} = {_toml_value(v)}" for key, v in table.items() if not isinstance(v, dict)]
    text = (f"[{name}]\n" if name else "") + "".join(line + "\n" for line in lines)
    for key, value in table.items():
        if isinstance(value, dict):
            text += _toml(value, f"{name}.{key}" if name else key)
    return text


class Tool:
    """A tool from the keys of a tool file: kerf.Tool({"format": "kerf-tool", ...}), or from its text."""

    def __init__(self, content=None, *, file=""):
        self.file = os.fspath(file)
        self.text = content if isinstance(content, str) else _toml(content or {})


def tool(name):
    """A tool of the rack by its id, "856-016", or a tool file."""
    return Tool(file=_kerf.find_tool(os.fspath(name)))


def tools():
    """The ids of the rack."""
    return _kerf.tool_ids()


def read(path, progress=None):
    """Reads STL, PLY, OBJ, OFF or 3MF. The mesh has .unit as the file declares it ("" if it does not) and .notes."""
    return _kerf.read(os.fspath(path), progress)


def check(mesh):
    """Judges a mesh as printed: .ready, .reasons, .volume_mm3."""
    return _kerf.check(mesh)


def open(folder):  # noqa: A001: kerf.open reads well
    """Opens a case that was baked before."""
    return _kerf.open(os.fspath(folder))


def export(folder, progress=None):
    """The mesh that `kerf export` writes: of a run as cut, with its pieces at their places; the solid of a case."""
    return _kerf.export(os.fspath(folder), progress)


def bake(mesh, voxel=0.1, *, unit=None, base="", base_height=None, close="auto", occlusal_plane=False,
         base_direction=None, progress=None):
    """Closes a surface and bakes its distance field. unit: "mm", "cm", "m", "um", "inch"; None: as the file declares
    it, else by size. base: "horseshoe" or "full". close: "auto", "base", "repair" or "wrap"."""
    if unit is None:
        unit = getattr(mesh, "unit", "")
    return _kerf.bake(mesh, voxel, unit, base, base_height, close, occlusal_plane, base_direction, progress)


def _cut(self, tool, path, *, times=None, force=None, progress=None):
    """Cuts along a path: a file, or an array (n, 3) of tips or (n, 7) with attitudes qw, qx, qy, qz. force: N with
    which a virtual hand pushes; None: the tool removes its volume without resistance."""
    if isinstance(tool, str):
        tool = globals()["tool"](tool)
    if isinstance(path, os.PathLike):
        path = os.fspath(path)
    return self._cut(tool.file, "" if tool.file else tool.text, path, times, force, progress)


Case.cut = _cut

__all__ = ["Case", "Check", "Cut", "Error", "Mesh", "Tool", "bake", "check", "export", "open", "read", "tool", "tools"]
