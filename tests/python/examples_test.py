"""The Blender add-on and the examples of docs/guide/library.md, with stand-ins for Blender, trimesh and PyVista that
check what they are given. With `blender --background --python FILE` the add-on runs in the real one.
"""
import contextlib
import importlib.util
import os
import pathlib
import re
import sys
import tempfile
import types
import unittest

import numpy as np

import kerf

try:
    import bpy
    IS_BLENDER = True
except ImportError:
    IS_BLENDER = False

ROOT = pathlib.Path(__file__).resolve().parents[2]
CORNERS = np.array([[x, y, z] for z in (-3.0, 0.0) for y in (-2.0, 2.0) for x in (-2.0, 2.0)])
FACES = np.array([[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4],
                  [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5]])
ACROSS = np.array([[-1.0, 0, 2], [-1, 0, -0.5], [1, 0, -0.5]])


def stand_in_for_blender():
    """The part of bpy that the add-on uses."""
    made = types.ModuleType("bpy")
    made.props = types.ModuleType("bpy.props")
    for name in ("StringProperty", "EnumProperty", "BoolProperty"):
        setattr(made.props, name, lambda **keys: keys)

    class Mesh:
        def __init__(self, name):
            self.name = name

        def from_pydata(self, vertices, edges, faces):
            assert all(len(v) == 3 for v in vertices) and edges == []
            assert all(0 <= i < len(vertices) for face in faces for i in face)
            self.vertices = [types.SimpleNamespace(co=np.float32(v)) for v in vertices]
            self.polygons = [types.SimpleNamespace(vertices=tuple(f)) for f in faces]

        def update(self):
            self.is_updated = True

    class Object(dict):
        def __init__(self, name, data):
            super().__init__()
            self.name, self.data = name, data

    linked = []
    made.data = types.SimpleNamespace(meshes=types.SimpleNamespace(new=Mesh), objects=types.SimpleNamespace(new=Object))
    menu = []
    made.types = types.SimpleNamespace(AddonPreferences=object, Operator=object,
                                       TOPBAR_MT_file_import=types.SimpleNamespace(append=menu.append, remove=menu.remove))
    made.utils = types.SimpleNamespace(register_class=lambda c: None, unregister_class=lambda c: None)
    made.context = types.SimpleNamespace(
        preferences=types.SimpleNamespace(addons={}), collection=types.SimpleNamespace(objects=types.SimpleNamespace(link=linked.append)),
        view_layer=types.SimpleNamespace(objects=types.SimpleNamespace(active=None)))
    made.menu, made.linked = menu, linked
    return made


class Examples(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.case = kerf.bake(kerf.Mesh(CORNERS, FACES), voxel=0.2, unit="mm")
        cls.cut = cls.case.cut("round-014", ACROSS)
        cls.case.save(os.path.join(cls.folder.name, "arch.case"))
        cls.cut.save(os.path.join(cls.folder.name, "arch.run"))
        if not IS_BLENDER:
            made = stand_in_for_blender()
            sys.modules["bpy"], sys.modules["bpy.props"] = made, made.props
        spec = importlib.util.spec_from_file_location("kerf_import", ROOT / "python" / "blender" / "kerf_import.py")
        cls.addon = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(cls.addon)
        cls.addon.register()

    @classmethod
    def tearDownClass(cls):
        cls.addon.unregister()

    def test_export_is_the_mesh_of_the_cut_and_the_solid_of_the_case(self):
        for name, wanted in [("arch.run", self.cut.mesh), ("arch.case", self.case.solid)]:
            mesh = kerf.export(os.path.join(self.folder.name, name))
            np.testing.assert_array_equal(mesh.vertices, wanted.vertices)
            np.testing.assert_array_equal(mesh.faces, wanted.faces)
        with self.assertRaises(kerf.Error):
            kerf.export(os.path.join(self.folder.name, "none.case"))

    def import_into_blender(self, name, scale):
        """The imported object; None with its errors if it was refused."""
        bpy = sys.modules["bpy"]
        path = os.path.join(self.folder.name, name) + os.sep
        if IS_BLENDER:
            before = set(bpy.data.objects)
            try:
                bpy.ops.import_mesh.kerf(directory=path, scale=scale)
            except RuntimeError as error:
                return None, str(error)
            return (set(bpy.data.objects) - before).pop(), ""
        operator = self.addon.ImportKerf()
        operator.directory, operator.scale, operator.module_folder = path, scale, ""
        said = []
        operator.report = lambda kind, text: said.append(text)
        result = operator.execute(bpy.context)
        return (bpy.linked[-1], "") if result == {"FINISHED"} else (None, " ".join(said))

    def test_the_add_on_opens_a_case_and_a_run_in_the_chosen_size(self):
        for name, mesh in [("arch.case", self.case.solid), ("arch.run", self.cut.mesh)]:
            for scale, factor in [("MM", 1.0), ("M", 0.001)]:
                made, error = self.import_into_blender(name, scale)
                self.assertIsNotNone(made, error)
                at = np.array([tuple(v.co) for v in made.data.vertices], np.float32)
                np.testing.assert_array_equal(at, (mesh.vertices * factor).astype(np.float32))
                np.testing.assert_array_equal([tuple(p.vertices) for p in made.data.polygons], mesh.faces)
                self.assertEqual(made["kerf_mm_per_unit"], 1 / factor)

    def test_the_add_on_refuses_another_folder_by_name(self):
        made, error = self.import_into_blender("none.case", "MM")
        self.assertIsNone(made)
        self.assertIn("none.case", error)

    @unittest.skipIf(IS_BLENDER, "the guide is run outside of it")
    def test_the_examples_of_the_guide_run(self):
        test = self

        class Trimesh:
            def __init__(self, vertices, faces, process=True):
                self.vertices, self.faces = np.asarray(vertices), np.asarray(faces)
                test.assertFalse(process)
                test.assertEqual(self.vertices.shape[1:], (3,))
                test.assertEqual(self.faces.shape[1:], (3,))
                self.is_watertight, self.area = True, 1.0

            def submesh(self, chosen, append):
                test.assertEqual([len(c) for c in chosen], [int(test.cut.is_cut.sum())])
                return self

            def export(self, path):
                test.assertEqual(len(self.faces), len(test.cut.is_cut))

        class PolyData:
            def __init__(self, points, faces):
                rows = np.asarray(faces).reshape(-1, 4)
                test.assertTrue((rows[:, 0] == 3).all() and rows[:, 1:].max() < len(points))
                self.cell_data = {}

            def plot(self, scalars, **_):
                test.assertEqual(self.cell_data[scalars].dtype, np.uint8)

        modules = {"trimesh": types.SimpleNamespace(Trimesh=Trimesh, load=lambda path, process: Trimesh(CORNERS, FACES, process)),
                   "pyvista": types.SimpleNamespace(PolyData=PolyData)}
        with open(os.path.join(self.folder.name, "path.csv"), "w") as file:
            file.write("t,x,y,z,qw,qx,qy,qz\n")
            for t, p in enumerate(ACROSS):
                file.write(",".join(str(v) for v in (t, *p, 1, 0, 0, 0)) + "\n")
        guide = (ROOT / "docs" / "guide" / "library.md").read_text()
        self.cut = self.case.cut("round-014", os.path.join(self.folder.name, "path.csv"))
        before = os.getcwd()
        os.chdir(self.folder.name)
        try:
            for name, module in modules.items():
                code = re.search(rf"```python {name}\n(.*?)```", guide, re.S).group(1)
                if name == "trimesh":
                    code = code.replace("voxel=0.1", "voxel=0.2")
                sys.modules[name] = module
                with open(os.devnull, "w") as nothing, contextlib.redirect_stdout(nothing):
                    exec(compile(code, f"library.md, {name}", "exec"), {})
        finally:
            os.chdir(before)


if __name__ == "__main__":
    result = unittest.main(argv=["examples_test"], exit=False).result
    sys.exit(0 if result.wasSuccessful() and result.testsRun else 1)
