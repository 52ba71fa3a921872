"""Runs the programs that the figures come from, and keeps the list of sheets."""
import json
import os
import pathlib
import subprocess
import sys

from PIL import Image

import models

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
DATA = ROOT / "data"
SHEETS = {}
# Of its control mesh's extent: below it a picture shows the mesh by itself, and the two together beside it.
SMALL = 0.5
# Few enough for the steps of a scheme to show.
BUNNY_TRIANGLES = 500


def sheet(make):
    SHEETS[make.__name__] = make
    return make


def run(*command):
    result = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if result.returncode != 0:
        sys.exit(f"figures: {' '.join(str(c) for c in command)}\n{result.stderr}")
    return result.stdout


class Maker:
    def __init__(self, build, out):
        self.build, self.out = pathlib.Path(build), pathlib.Path(out)
        self.tool = self.build / "tools" / "figure_data"
        self.meshes = self.out / "meshes"
        self.meshes.mkdir(parents=True, exist_ok=True)
        self.work = self.out / "work"
        self.work.mkdir(exist_ok=True)

    def obj(self, name, points, faces):
        return models.write_obj(self.work / f"{name}.obj", points, faces)

    def refine(self, path, scheme, levels, option=None, keep=True):
        """A control mesh refined: points, faces; the GLB stays in meshes/ under the names of both."""
        name = f"{pathlib.Path(path).stem}_{scheme}" + (f"_{option}" if option is not None else "") + f"_{levels}"
        plain = self.work / f"{name}.obj"
        more = [] if option is None else ["--steps" if scheme == "averaging" else "--tuning", option]
        for out in (plain, self.meshes / f"{name}.glb") if keep else (plain,):
            run(self.build / "tetrakis", "refine", path, "--scheme", scheme, "--levels", levels, *more, "-o", out)
        return models.read_obj(plain)

    def factored(self, path, scheme, steps, *more):
        """Half-steps of a factored scheme: points, faces, and the numbers of inactive vertices."""
        out, report = self.work / "_factored.obj", self.work / "_factored.json"
        run(self.build / "tetrakis", "refine", path, "--factored", "--scheme", scheme, "--steps", steps, *more, "-o", out, "--report", report)
        return *models.read_obj(out), set(json.loads(report.read_text())["inactive_vertices"])

    def picture(self, points, faces, size=(340, 300), camera="32,20", up="y", flags=()):
        # The camera is fitted to all points: only to those that are shown.
        used = sorted({v for f in faces for v in f})
        number = {v: i for i, v in enumerate(used)}
        mesh, image = self.obj("_picture", [points[v] for v in used], [[number[v] for v in f] for f in faces]), self.work / "_picture.png"
        run(self.build / "tetrakis", "render", mesh, "-o", image, "--size", f"{size[0]}x{size[1]}",
            f"--camera={camera}", "--up", up, *flags)
        with Image.open(image) as picture:
            return picture.copy()

    def framed(self, control, fine, size, camera=(32, 20)):
        """The refined mesh in the outline of its control mesh; where it is much smaller, itself and beside it that."""
        extent = [max(max(p[i] for p in points) - min(p[i] for p in points) for i in range(3)) for points, _ in (control, fine)]
        if extent[1] < SMALL * extent[0]:
            width = size[0] * 3 // 5
            both = Image.new("RGB", size, "white")
            both.paste(self.picture(*fine, (width, size[1]), camera="%g,%g" % camera), (0, 0))
            side = size[0] - width - 4
            whole = self.outlined(control, fine, (2 * side, 2 * side), camera).resize((side, side), Image.LANCZOS)
            both.paste(whole, (width + 4, 0))
            return both
        return self.outlined(control, fine, size, camera)

    def outlined(self, control, fine, size, camera):
        image = self.work / "_picture.png"
        run(self.tool, "picture", self.obj("_picture", *fine), self.obj("_control", *control), image, *size, *camera)
        with Image.open(image) as picture:
            return picture.copy()

    def bunny(self):
        """A scan, simplified; None where it is not there."""
        shared = pathlib.Path(os.environ.get("TETRAKIS_SHARED_DIR") or ROOT.parent / "shared")
        scan, mesh = shared / "data" / "models" / "stanford-bunny.obj", self.work / "bunny.obj"
        if not scan.exists():
            print(f"figures: no bunny, because there is no {scan}", flush=True)
            return None
        if not mesh.exists():
            run(self.tool, "simplify", scan, BUNNY_TRIANGLES, mesh)
        return mesh

    def edges(self, points, faces, size, camera=(32, 20)):
        """A polygon mesh, each face flat, with its own edges: no diagonals."""
        image, mesh = self.work / "_picture.png", self.obj("_picture", points, faces)
        run(self.tool, "picture", mesh, mesh, image, *size, *camera, "edges")
        with Image.open(image) as picture:
            return picture.copy()

    def scheme(self, name, valence, *more):
        return json.loads(run(self.build / "tetrakis", "scheme", name, "--valence", valence, "--json", *more))

    def save(self, s, name):
        s.save(self.out / f"{name}.png")
        print(self.out / f"{name}.png", flush=True)
