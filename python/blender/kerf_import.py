"""Blender add-on: opens a case (.case) or a run (.run) of Kerf. A run becomes its mesh for the printer.

Install: Edit > Preferences > Add-ons > Install, choose this file, tick it. Then File > Import > Kerf case or run.
It needs the Python module kerf for Blender's Python: the package python3-kerf with Debian's Blender.
"""

import importlib
import os
import sys

import bpy
from bpy.props import EnumProperty, StringProperty

bl_info = {
    "name": "Kerf case or run",
    "author": "Kerf developers",
    "version": (1, 0, 0),
    "blender": (3, 4, 0),
    "location": "File > Import > Kerf case or run",
    "description": "Opens a case or a run of Kerf as a mesh, in mm",
    "category": "Import-Export",
}

SCALES = {"MM": 1.0, "M": 0.001}


class KerfPreferences(bpy.types.AddonPreferences):
    bl_idname = __name__

    module_folder: StringProperty(
        name="Folder of the module kerf", subtype="DIR_PATH",
        description="Folder that holds kerf/__init__.py, such as ~/.local/lib/python3/dist-packages")

    def draw(self, context):
        self.layout.prop(self, "module_folder")


def find_kerf(folder):
    """The module: as Blender finds it, else in the folder. Raises ImportError."""
    try:
        return importlib.import_module("kerf")
    except ImportError:
        if not folder:
            raise
    sys.path.append(os.path.expanduser(folder))
    try:
        return importlib.import_module("kerf")
    finally:
        sys.path.pop()


def make_object(context, name, mesh, scale):
    data = bpy.data.meshes.new(name)
    data.from_pydata((mesh.vertices * scale).tolist(), [], mesh.faces.tolist())
    data.update()
    made = bpy.data.objects.new(name, data)
    context.collection.objects.link(made)
    context.view_layer.objects.active = made
    return made


class ImportKerf(bpy.types.Operator):
    """Open a case or a run of Kerf"""

    bl_idname = "import_mesh.kerf"
    bl_label = "Import Kerf case or run"
    bl_options = {"REGISTER", "UNDO"}

    directory: StringProperty(subtype="DIR_PATH")
    filter_folder: bpy.props.BoolProperty(default=True, options={"HIDDEN"})
    scale: EnumProperty(
        name="Size", default="MM",
        items=[("MM", "1 unit = 1 mm", "Coordinates as in Kerf: set the scene's unit scale to 0.001"),
               ("M", "1 unit = 1 m", "Coordinates divided by 1000, for scenes in metres")])
    module_folder: StringProperty(
        name="Module kerf", subtype="DIR_PATH",
        description="Folder that holds kerf/__init__.py; empty: where Blender finds it, or as in the preferences")

    def invoke(self, context, event):
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def draw(self, context):
        self.layout.label(text="Enter a .case or .run folder. Kerf measures in mm.")
        self.layout.prop(self, "scale")
        self.layout.prop(self, "module_folder")

    def execute(self, context):
        folder = self.directory.rstrip(os.sep)
        known = context.preferences.addons.get(__name__)
        module_folder = self.module_folder or (known.preferences.module_folder if known else "")
        try:
            kerf = find_kerf(module_folder)
        except ImportError as error:
            self.report({"ERROR"}, f"The Python module kerf cannot be loaded: {error}. Install python3-kerf, or name the "
                                   f"folder that holds it; it must fit Python {sys.version_info[0]}.{sys.version_info[1]}")
            return {"CANCELLED"}
        try:
            mesh = kerf.export(folder)
        except kerf.Error as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        made = make_object(context, os.path.splitext(os.path.basename(folder))[0], mesh, SCALES[self.scale])
        made["kerf_folder"] = folder
        made["kerf_mm_per_unit"] = 1 / SCALES[self.scale]
        self.report({"INFO"}, f"{len(mesh.faces)} triangles, {'1 unit = 1 mm' if self.scale == 'MM' else '1 unit = 1 m'}")
        return {"FINISHED"}


def add_to_menu(self, context):
    self.layout.operator(ImportKerf.bl_idname, text="Kerf case or run (.case, .run)")


def register():
    bpy.utils.register_class(KerfPreferences)
    bpy.utils.register_class(ImportKerf)
    bpy.types.TOPBAR_MT_file_import.append(add_to_menu)


def unregister():
    bpy.types.TOPBAR_MT_file_import.remove(add_to_menu)
    bpy.utils.unregister_class(ImportKerf)
    bpy.utils.unregister_class(KerfPreferences)
