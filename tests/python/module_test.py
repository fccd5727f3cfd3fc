"""The Python module: arrays, errors, progress, Ctrl-C, forces, saving. Run with PYTHONPATH at the built package and
KERF at the built program."""
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
import tomllib
import unittest

import numpy as np

import kerf

CORNERS = np.array([[x, y, z] for z in (-3.0, 0.0) for y in (-2.0, 2.0) for x in (-2.0, 2.0)])
FACES = np.array([[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4],
                  [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5]])
ACROSS = np.array([[-1.0, 0, 2], [-1, 0, -0.5], [1, 0, -0.5]])


KERF = os.environ.get("KERF", "")
# Bakes a block at fine voxels, which takes a minute, and sends itself Ctrl-C from the progress function at a step;
# "silence": in a loop that has reported nothing for 0.3 s of CPU, and so cannot be cancelled. Tells the CPU time of all
# threads from the signal to the exception, on two cores at most.
LONG_BAKE = """
import os, signal, sys, threading, time
import numpy as np
import kerf
signal.signal(signal.SIGINT, signal.default_int_handler)
os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:2])
wanted, vertices, faces = sys.argv[1], *(np.array(eval(text)) for text in sys.argv[2:])
last, sent = [0.0, ""], []
def send():
    sent.append(time.process_time())
    os.kill(os.getpid(), signal.SIGINT)
def listen():
    while last[1] != "distance field" or time.process_time() < last[0] + 0.3:
        time.sleep(0.005)
    send()
def told(done, step):
    last[:] = time.process_time(), step
    if step == wanted:
        send()
if wanted == "silence":
    threading.Thread(target=listen, daemon=True).start()
try:
    kerf.bake(kerf.Mesh(vertices, faces), voxel=0.05, unit="mm", progress=told)
    print("ended late" if sent else "ended", flush=True)
except KeyboardInterrupt:
    print("interrupted", time.process_time() - sent[0], flush=True)
os._exit(0)  # the thread left behind costs no more
"""


class Unclear:
    def __bool__(self):
        raise LookupError("neither true nor false")


def block():
    return kerf.Mesh(CORNERS, FACES)


class Module(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.case = kerf.bake(block(), voxel=0.1, unit="mm")

    def test_arrays_are_views_and_stay_when_the_mesh_goes(self):
        mesh = block()
        vertices, faces = mesh.vertices, mesh.faces
        del mesh
        self.assertEqual(vertices.dtype, np.float64)
        self.assertEqual(faces.dtype, np.uint32)
        np.testing.assert_array_equal(vertices, CORNERS)
        np.testing.assert_array_equal(faces, FACES)
        with self.assertRaises(ValueError):
            vertices[0, 0] = 1

    def test_wrong_arrays_are_refused(self):
        for vertices, faces, place in [(CORNERS[:, :2], FACES, "vertices"), (CORNERS, FACES + 7, "face 0"),
                                       (CORNERS * np.nan, FACES, "vertex 0"), (CORNERS, FACES - 1, "face 0")]:
            with self.assertRaises(kerf.Error) as caught:
                kerf.Mesh(vertices, faces)
            self.assertEqual(caught.exception.place, place)
            self.assertTrue(caught.exception.expected)

    def test_a_cut_removes_the_swept_volume(self):
        cut = self.case.cut(kerf.tool("round-014"), ACROSS)
        report = kerf.check(cut.mesh)
        self.assertTrue(report.ready, report.reasons)
        self.assertAlmostEqual(report.volume_mm3, 48 - cut.removed_mm3, places=3)
        # Half a ball of 1.4 mm, a groove 2 mm long with its 0.5 mm below the surface: by the section of a disc.
        r, depth = 0.7, 0.5
        section = r * r * np.arccos(1 - depth / r) - (r - depth) * np.sqrt(2 * r * depth - depth * depth)
        cap = np.pi * depth * depth * (r - depth / 3)
        self.assertAlmostEqual(cut.removed_mm3, 2 * section + cap, delta=0.02 * cut.removed_mm3)
        self.assertLess(cut.wall_um, 100)
        self.assertEqual(len(cut.is_cut), len(cut.mesh.faces))
        self.assertTrue(cut.is_cut.any() and not cut.is_cut.all())

    def test_against_resistance_it_has_forces(self):
        cut = self.case.cut("round-014", ACROSS, force=1.0)
        self.assertGreater(len(cut.forces), 100)
        self.assertGreater(cut.forces["contact_N"].max(), 0.5)
        self.assertTrue((np.diff(cut.forces["t_s"]) > 0).all())

    def test_a_tool_from_a_dictionary_cuts_as_that_of_the_rack(self):
        rack = kerf.tool("round-014")
        with open(rack.file, "rb") as file:
            keys = tomllib.load(file)
        cut, wanted = self.case.cut(kerf.Tool(keys), ACROSS), self.case.cut(rack, ACROSS)
        np.testing.assert_array_equal(cut.mesh.vertices, wanted.mesh.vertices)

    def test_a_dictionary_that_is_no_tool_is_refused(self):
        keys = {"format": "kerf-tool", "version": 1}
        with self.assertRaises(kerf.Error) as caught:
            self.case.cut(kerf.Tool(keys), ACROSS)
        self.assertIn("tool.toml", caught.exception.file)

    def test_a_path_in_the_air_is_an_error(self):
        with self.assertRaises(kerf.Error) as caught:
            self.case.cut("round-014", ACROSS + [0, 0, 100])
        self.assertEqual(caught.exception.code, "empty")

    def test_distance_is_signed(self):
        near = self.case.distance([[0, 0, -0.2], [0, 0, 0.0], [0, 0, 0.2], [0, 0, 50]])
        np.testing.assert_allclose(near[:3], [-0.2, 0, 0.2], atol=0.02)
        self.assertGreater(near[3], 0.2)

    def test_saved_it_opens_again_and_cuts_the_same(self):
        with tempfile.TemporaryDirectory() as folder:
            case = kerf.bake(block(), voxel=0.1, unit="mm")
            cut = case.cut("round-014", ACROSS)
            with self.assertRaises(kerf.Error):
                cut.save(os.path.join(folder, "early.run"))
            case.save(os.path.join(folder, "block.case"))
            cut.save(os.path.join(folder, "block.run"))
            with self.assertRaises(kerf.Error):
                case.save(os.path.join(folder, "block.case"))
            again = kerf.open(os.path.join(folder, "block.case")).cut("round-014", ACROSS)
            np.testing.assert_array_equal(again.mesh.vertices, cut.mesh.vertices)
            self.assertTrue(os.path.isfile(os.path.join(folder, "block.run", "run.toml")))

    def test_progress_can_cancel_and_its_error_comes_out(self):
        seen = []
        with self.assertRaises(kerf.Error) as caught:
            kerf.bake(block(), voxel=0.1, unit="mm", progress=lambda done, step: seen.append((done, step)) or len(seen) < 2)
        self.assertEqual(caught.exception.code, "cancelled")
        self.assertGreaterEqual(len(seen), 2)
        with self.assertRaises(ZeroDivisionError):
            kerf.bake(block(), voxel=0.1, unit="mm", progress=lambda done, step: 1 / 0)

    def test_an_answer_of_progress_counts_by_its_truth(self):
        def bake(answer):
            return kerf.bake(block(), voxel=0.2, unit="mm", progress=lambda done, step: answer)

        for answer in (None, "on", [0], np.True_, object()):
            self.assertGreater(bake(answer).report["volume_mm3"], 40)
        for answer in ("", [], 0, np.False_):
            with self.assertRaises(kerf.Error) as caught:
                bake(answer)
            self.assertEqual(caught.exception.code, "cancelled")
        for answer, error in [(Unclear(), LookupError), (np.zeros(2), ValueError)]:
            with self.assertRaises(error):
                bake(answer)
            with self.assertRaises(error):
                self.case.cut("round-014", ACROSS, progress=lambda done, step: answer)

    def test_ctrl_c_comes_out_of_a_long_bake(self):
        most = 2.0  # s of CPU: 0.4 s on two cores, and room for a loaded machine
        for step in ["welding", "silence"]:
            with self.subTest(step=step):
                said = subprocess.run([sys.executable, "-c", LONG_BAKE, step, str((CORNERS * 10).tolist()), str(FACES.tolist())],
                                      stdout=subprocess.PIPE, text=True, check=True, timeout=300).stdout.split("\n")
                if step == "silence" and said[0] == "ended":
                    continue  # a machine so fast that no loop is long
                self.assertRegex(said[0], "^interrupted ")
                took = float(said[0].split()[1])
                print(f"Ctrl-C in {step}: {took:.2f} s of CPU", file=sys.stderr)
                self.assertLessEqual(took, most)

    @unittest.skipUnless(KERF, "KERF names no program")
    def test_poses_cut_as_the_same_path_file_of_the_program(self):
        steps = np.linspace(0, 1, 24)
        angle = 0.4 * steps
        poses = np.column_stack([2 * steps - 1, 0.3 * np.sin(5 * steps), -0.6 * steps, np.cos(angle / 2),
                                 np.sin(angle / 2) * 0.6, np.sin(angle / 2) * 0.8, 0 * steps])
        times = 1.5 * steps + 0.1 * steps ** 2
        with tempfile.TemporaryDirectory() as folder:
            with open(os.path.join(folder, "path.csv"), "w") as file:
                file.write("t,x,y,z,qw,qx,qy,qz\n")
                for t, pose in zip(times, poses):
                    file.write(",".join(repr(float(v)) for v in (t, *pose)) + "\n")
            block().write(os.path.join(folder, "block.ply"))
            for words in ["bake block.ply --unit mm --voxel 0.1 -o block.case",
                          "cut block.case --tool 856-016 --path path.csv -o block.run", "export block.run -o program.stl"]:
                subprocess.run([KERF, *words.split()], cwd=folder, check=True, stdout=subprocess.DEVNULL)
            cut = self.case.cut("856-016", poses, times=times)
            cut.mesh.write(os.path.join(folder, "module.stl"))
            with open(os.path.join(folder, "program.stl"), "rb") as a, open(os.path.join(folder, "module.stl"), "rb") as b:
                self.assertEqual(a.read(), b.read())
            straight = self.case.cut("856-016", poses[:, :3], times=times)
            self.assertNotEqual(cut.removed_mm3, straight.removed_mm3)

    def test_other_threads_run_meanwhile(self):
        ticks = [0]
        stop = threading.Event()

        def tick():
            while not stop.is_set():
                ticks[0] += 1
                time.sleep(0.001)

        calls = {"bake": lambda: kerf.bake(block(), voxel=0.1, unit="mm"),
                 "cut": lambda: self.case.cut("round-014", ACROSS), "tools": kerf.tools}
        interval = sys.getswitchinterval()
        thread = threading.Thread(target=tick)
        thread.start()
        # No thread gets the lock from another by force: it ticks only if the call releases the lock.
        sys.setswitchinterval(1000)
        try:
            for name, call in calls.items():
                advanced = False
                for _ in range(50):
                    before = ticks[0]
                    call()
                    advanced = advanced or ticks[0] > before
                    if advanced:
                        break
                self.assertTrue(advanced, name)
        finally:
            sys.setswitchinterval(interval)
            stop.set()
            thread.join()


if __name__ == "__main__":
    unittest.main()
