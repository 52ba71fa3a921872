#!/usr/bin/env python3
"""The standard comparisons of subdivision schemes as contact sheets, made by the program; see tools/figures.sh.

    tools/figures.py BUILD_DIR OUT_DIR [SHEET...]     names of sheets; without: all
"""
import json
import math
import pathlib
import subprocess
import sys

from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tools" / "figures"))
import models  # noqa: E402
import tilings  # noqa: E402
from sheet import BLUE, GREY, INK, ORANGE, PALE, RED, Plane, Sheet  # noqa: E402

DATA = ROOT / "data"
SHEETS = {}


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
        more = [] if option is None else [option]
        run(self.tool, "refine", path, scheme, levels, self.work / f"{name}.obj", *more)
        if keep:
            run(self.tool, "refine", path, scheme, levels, self.meshes / f"{name}.glb", *more)
        return models.read_obj(self.work / f"{name}.obj")

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
        """The refined mesh in the outline of its control mesh."""
        image = self.work / "_picture.png"
        run(self.tool, "picture", self.obj("_picture", *fine), self.obj("_control", *control), image, *size, *camera)
        with Image.open(image) as picture:
            return picture.copy()

    def scheme(self, name, valence, *more):
        return json.loads(run(self.build / "tetrakis", "scheme", name, "--valence", valence, "--json", *more))

    def save(self, s, name):
        s.save(self.out / f"{name}.png")
        print(self.out / f"{name}.png", flush=True)


def plane_points(points):
    return [(p.real, p.imag, 0.0) for p in points]


# --- curves and tilings ---------------------------------------------------------------------------------------------


@sheet
def curves(make):
    data = json.loads(run(make.tool, "curves"))
    s = Sheet("Curves: Bezier split, B-splines of degree 1 to 4, four-point", 3, (420, 285),
              "grey: control polygon; orange: the points of one step; blue: the curve, within 0.0001")

    def draw(control, step, curve, closed=None):
        p = Plane((420, 285), (-0.3, -0.2), (3.35, 2.2))
        p.line(control, GREY, 1.3)
        if closed:
            p.line(closed, (170, 200, 235), 1.6, closed=True)
        p.line(curve, BLUE, 2.4)
        for q in step:
            p.dot(q, ORANGE, 3)
        for q in control:
            p.dot(q, INK, 4)
        return p.picture()

    b = data["bezier"]
    p = Plane((420, 285), (-0.3, -0.2), (3.35, 2.2))
    p.line(b["control"], GREY, 1.3)
    p.line(b["first"], RED, 1.3)
    p.line(b["second"], ORANGE, 1.3)
    p.line(b["curve"], BLUE, 2.4)
    for points, colour in ((b["control"], INK), (b["first"], RED), (b["second"], ORANGE)):
        for q in points:
            p.dot(q, colour, 4)
    s.add(p.picture(), "Bezier, split at 1/2\nde Casteljau: the two halves' control points")
    p = Plane((420, 285), (-0.3, -0.2), (3.35, 2.2))
    p.line(b["control"], PALE, 1.3)
    p.line(b["curve"], BLUE, 2.4)
    for part, colour in (("first_first", RED), ("first_second", ORANGE), ("second", INK)):
        p.line(b[part], colour, 1.3)
        for q in b[part]:
            p.dot(q, colour, 3.5)
    s.add(p.picture(), "and the first half once more\npolygons approach the curve")
    for c in data["bspline"]:
        s.add(draw(c["control"], c["step"], c["curve"], c["closed"]),
              f"B-spline of degree {c['degree']}\nopen (ends recede), pale: closed")
    c = data["four_point"]
    s.add(draw(c["control"], c["step"], c["curve"], c["closed"]), "four-point, interpolating\nopen (cubic ends), pale: closed")
    make.save(s, "curves")


TILE_COLOURS = {3: (246, 226, 180), 4: (190, 214, 236), 5: (210, 232, 206), 6: (233, 200, 190), 8: (214, 202, 230), 12: (205, 226, 222)}


def tiling_picture(points, faces, reach, size=300):
    p = Plane((size, size), (-reach, -reach), (reach, reach))
    for f in faces:
        p.polygon([(points[v].real, points[v].imag) for v in f], TILE_COLOURS.get(len(f), (240, 240, 240)))
    for f in faces:
        p.line([(points[v].real, points[v].imag) for v in f], INK, 1.4, closed=True)
    return p.picture()


@sheet
def archimedean_tilings(make):
    s = Sheet("The 11 Archimedean tilings", 4, (300, 300), "named by the tiles around a vertex")
    for name in tilings.cells():
        reach = 4.4 if "12" in name or "8" in name else 3.4
        s.add(tiling_picture(*tilings.tiling(name, reach * 1.5 + 3), reach), name)
    make.save(s, "archimedean_tilings")


@sheet
def laves_tilings(make):
    s = Sheet("The 11 Laves tilings", 4, (300, 300), "named by the valences around a tile; each is the dual of the Archimedean tiling of that name")
    for name in tilings.cells():
        reach = 4.4 if "12" in name or "8" in name else 3.4
        s.add(tiling_picture(*tilings.dual(*tilings.tiling(name, reach * 1.5 + 3)), reach), f"[{name}]")
    make.save(s, "laves_tilings")


@sheet
def refinement_rules(make):
    s = Sheet("Refinement rules on their tilings", 4, (330, 330), "grey, wide: before; blue: after one step of the scheme in brackets")
    rules = [("3^6", "midpoint", "face split of triangles\n(midpoint)"),
             ("4^4", "bilinear", "face split of quads\n(bilinear)"),
             ("4^4", "doo-sabin", "vertex split of quads\n(doo-sabin)"),
             ("3^6", "doo-sabin", "vertex split of triangles\n(doo-sabin): no triangle tiling comes out"),
             ("6^3", "honeycomb", "honeycomb\n(honeycomb)"),
             ("3^6", "sqrt3", "sqrt(3), its two simple steps at once\n(sqrt3)"),
             ("4.8^2 dual", "4-8", "bisection, its two simple steps at once\n(4-8, on the tiling [4.8^2])")]
    for name, scheme, caption in rules:
        reach = 1.75
        if name.endswith("dual"):
            # The blocks of the tetrakis tiling are squares, which the scheme takes; its triangles are their quarters.
            points, faces = tilings.tiling("4^4", 7)
            control = make.obj("_blocks", plane_points(points), faces)
        else:
            points, faces = tilings.tiling(name, 7)
            control = make.obj("_tiling", plane_points(points), faces)
        fine_points, fine = make.refine(control, scheme, 1, keep=False)
        if name.endswith("dual"):
            cut = lambda p, q: ([*p, *(tuple(sum(p[v][i] for v in f) / 4 for i in range(3)) for f in q)],
                                [[a, b, len(p) + k] for k, f in enumerate(q) for a, b in zip(f, f[1:] + f[:1])])
            before_points, before = cut(plane_points(points), faces)
            fine_points, fine = cut(fine_points, fine)
        else:
            before_points, before = plane_points(points), faces
        if name == "6^3":
            reach = 2.3
        p = Plane((330, 330), (-reach, -reach), (reach, reach))
        for f in before:
            p.line([before_points[v][:2] for v in f], (196, 202, 212), 6, closed=True)
        for f in fine:
            p.line([fine_points[v][:2] for v in f], BLUE, 1.6, closed=True)
        s.add(p.picture(), caption)
    make.save(s, "refinement_rules")


# --- surfaces -------------------------------------------------------------------------------------------------------


@sheet
def cube_and_tetrahedron(make):
    s = Sheet("Cube and tetrahedron under five schemes", 6, (300, 280),
              "in the outline of the control mesh; volume as a share of the control mesh's")
    for name in ("cube", "tetrahedron"):
        control = models.read_obj(DATA / f"{name}.obj")
        s.add(make.picture(*control, (300, 280)), f"{name}\ncontrol mesh")
        for scheme, levels in (("loop", 5), ("butterfly", 5), ("modified-butterfly", 5), ("catmull-clark", 5), ("doo-sabin", 5)):
            fine = make.refine(DATA / f"{name}.obj", scheme, levels)
            share = models.volume(*fine) / models.volume(*control)
            s.add(make.framed(control, fine, (300, 280)),
                  f"{scheme}\nvolume {100 * share:.1f} %" + ("; kinks at valence 3" if scheme == "butterfly" else ""))
    make.save(s, "cube_and_tetrahedron")


@sheet
def tetrahedron_loop(make):
    s = Sheet("A tetrahedron under Loop, level by level", 3, (400, 350))
    control = models.read_obj(DATA / "tetrahedron.obj")
    for level in (0, 1, 2, 3, 4, 6):
        fine = make.refine(DATA / "tetrahedron.obj", "loop", level)
        share = models.volume(*fine) / models.volume(*control)
        smooth = level == 6
        s.add(make.picture(*fine, (400, 350), flags=() if smooth else ("--flat", "--wireframe")),
              f"level {level}: {len(fine[1])} triangles" + f"\nvolume {100 * share:.1f} %")
    make.save(s, "tetrahedron_loop")


@sheet
def averaging_steps(make):
    s = Sheet("Repeated averaging: volume falls with the number of steps", 3, (400, 350),
              "the cube, in its outline; two steps are nearly Catmull-Clark")
    control = models.read_obj(DATA / "cube.obj")
    for steps in (0, 1, 2, 3, 4):
        fine = make.refine(DATA / "cube.obj", "averaging", 5, steps)
        s.add(make.framed(control, fine, (400, 350)),
              f"{steps} averaging step{'' if steps == 1 else 's'}\nvolume {100 * models.volume(*fine) / models.volume(*control):.1f} %")
    fine = make.refine(DATA / "cube.obj", "catmull-clark", 5)
    s.add(make.framed(control, fine, (400, 350)),
          f"Catmull-Clark\nvolume {100 * models.volume(*fine) / models.volume(*control):.1f} %")
    make.save(s, "averaging_steps")


@sheet
def head(make):
    s = Sheet("A head under Catmull-Clark and Doo-Sabin, and in triangles as few as a tolerance allows", 3, (420, 480))
    control = models.read_obj(DATA / "head.obj")
    view = {"size": (420, 480), "camera": "25,8"}
    s.add(make.picture(*control, **view, flags=("--flat", "--wireframe")), f"control mesh\n{len(control[1])} faces")
    s.add(make.picture(*make.refine(DATA / "head.obj", "catmull-clark", 3), **view), "Catmull-Clark\n3 levels")
    s.add(make.picture(*make.refine(DATA / "head.obj", "doo-sabin", 3), **view), "Doo-Sabin\n3 levels")
    for tolerance in ("1e-2", "3e-3", "1e-3"):
        mesh = make.meshes / f"head_{tolerance}.glb"
        image = make.work / "_head.png"
        run(make.build / "tetrakis", "tessellate", DATA / "head.obj", "--tolerance", tolerance, "--estimator", "certified", "-o", mesh, "--report", make.work / "_head.json")
        run(make.build / "tetrakis", "render", mesh, "-o", image, "--size", "420x480", "--camera=25,8", "--wireframe")
        report = json.loads((make.work / "_head.json").read_text())
        with Image.open(image) as picture:
            s.add(picture.copy(), f"adaptive, tolerance {tolerance}\n{report['triangles']} triangles, certified within {report['certified_error'] / report['tolerance_absolute'] * float(tolerance):.2g}")
    make.save(s, "head")


@sheet
def rook(make):
    s = Sheet("A chess rook", 4, (300, 440), "no creases; triangles of Loop and of the last picture by cutting faces at their shorter diagonal")
    points, faces = models.read_obj(DATA / "rook.obj")
    plain = make.obj("rook", points, faces)
    make.refine(plain, "loop", 0, keep=False)
    triangles = make.work / "rook_loop_0.obj"
    cut = models.read_obj(triangles)
    view = {"size": (300, 440), "camera": "32,18"}
    s.add(make.picture(points, faces, **view, flags=("--flat",)), f"control mesh\n{len(faces)} faces")
    s.add(make.picture(*make.refine(plain, "loop", 3), **view), "Loop\nafter triangulation")
    s.add(make.picture(*make.refine(plain, "catmull-clark", 3), **view), "Catmull-Clark")
    s.add(make.picture(*make.refine(make.obj("rook_cut", *cut), "catmull-clark", 3), **view), "Catmull-Clark\nafter triangulation: ripples")
    make.save(s, "rook")


@sheet
def dual_basis_functions(make):
    s = Sheet("Dual basis functions at a 4-gon and at a 9-gon", 3, (420, 300), "of one corner of the face; heights in one scale per row")
    for corners in (4, 9):
        points, faces = models.face_fan(corners, 3)
        reach = math.hypot(*points[0][:2]) + 3
        points = [(x, y, 1.0 if i == 0 else 0.0) for i, (x, y, _) in enumerate(points)]
        control = make.obj(f"dual_basis_{corners}", points, faces)
        for scheme in ("midedge", "doo-sabin", "biquartic"):
            fine, quads = make.refine(control, scheme, 5)
            peak = max(z for _, _, z in fine)
            tall = [(x, y, 1.3 * reach * z) for x, y, z in fine]
            s.add(make.picture(tall, quads, (420, 300), camera="25,30", up="z"), f"{scheme}, {corners}-gon\nlargest value {peak:.3f}")
    make.save(s, "dual_basis_functions")


@sheet
def dual_schemes_cube(make):
    s = Sheet("A cube under the three dual schemes", 3, (420, 380), "in the outline of the control polyhedron")
    control = models.read_obj(DATA / "cube.obj")
    for scheme in ("midedge", "doo-sabin", "biquartic"):
        fine = make.refine(DATA / "cube.obj", scheme, 6)
        s.add(make.framed(control, fine, (420, 380)), f"{scheme}\nvolume {100 * models.volume(*fine) / models.volume(*control):.1f} %")
    make.save(s, "dual_schemes_cube")


@sheet
def pipe(make):
    s = Sheet("A three-legged pipe with boundary", 3, (420, 400), "the rims follow their own curves: cubic and quadratic B-spline, four-point")
    control = models.read_obj(DATA / "pipe3.obj")
    view = {"size": (420, 400), "camera": "35,35"}
    s.add(make.picture(*control, **view, flags=("--flat",)), f"control mesh\n{len(control[1])} faces")
    for scheme in ("loop", "modified-butterfly", "catmull-clark", "doo-sabin", "kobbelt"):
        cut = "after triangulation" if scheme in ("loop", "modified-butterfly") else ""
        s.add(make.picture(*make.refine(DATA / "pipe3.obj", scheme, 4), **view),
              f"{scheme}\n" + ("interpolating " if scheme in ("modified-butterfly", "kobbelt") else "") + cut)
    make.save(s, "pipe")


@sheet
def extruded_pentagon(make):
    s = Sheet("An extruded pentagon", 3, (420, 380), "in the outline of the control mesh")
    control = models.read_obj(DATA / "extruded_pentagon.obj")
    s.add(make.picture(*control, (420, 380)), "control mesh")
    for scheme in ("catmull-clark", "doo-sabin"):
        fine = make.refine(DATA / "extruded_pentagon.obj", scheme, 5)
        s.add(make.framed(control, fine, (420, 380)), f"{scheme}\nvolume {100 * models.volume(*fine) / models.volume(*control):.1f} %")
    make.save(s, "extruded_pentagon")


# --- eigenvalues ----------------------------------------------------------------------------------------------------


def ridge(valence):
    """A fan of triangles bent to a parabolic ridge: smooth by nature, whatever ripples on it is the scheme's doing."""
    points, faces = models.triangle_fan(valence, 2)
    return [(x, y, -0.35 * x * x) for x, y, _ in points], faces


@sheet
def high_valence(make):
    s = Sheet("Loop at high valence: eigenvalues cluster at 5/8, and the surface ripples", 3, (420, 380),
              "other eigenvalues come up to the tangents' own, and a smooth ridge gets a pinch; tuned-loop has none")
    p = Plane((420, 380), (-4, -3), (67, 60))
    unit = 57.5
    valences = (3, 4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 48, 64)
    for level in (0.25, 0.375, 0.5, 0.625, 1):
        p.line([(0, level * unit), (64, level * unit)], PALE, 1)
        p.text((-1.6, level * unit), f"{level:g}", GREY, 10)
    for n in valences:
        values = make.scheme("loop", n)["eigenvalues"]
        for v in values:
            if abs(v["imaginary"]) < 1e-9 and v["real"] > 0.02:
                p.dot((n, v["real"] * unit), RED if v["mode"] == 1 and v["real"] > 0.24 and v["real"] == max(w["real"] for w in values if w["mode"] == 1) else BLUE, 2.4)
        p.text((n, -1.5), str(n), GREY, 9)
    s.add(p.picture(), "eigenvalues by valence\nred: the tangents', blue: all others")
    for n in (6, 12, 24, 48):
        for scheme in ("loop",) if n != 24 else ("loop", "tuned-loop"):
            fine = make.refine(make.obj(f"ridge_{n}", *ridge(n)), scheme, 5)
            s.add(make.picture(*fine, (420, 380), camera="35,42", up="z"), f"{scheme}, a ridge at valence {n}\n")
    make.save(s, "high_valence")


@sheet
def uneven_rings(make):
    s = Sheet("Rings of triangles around a vertex: Loop, and prescribed eigenvalues (subdominant 1/2)", 7, (250, 250),
              "three steps on a flat fan; the scheme tuned-loop has lambda = 1/2 at every valence, so its triangles are even")
    for scheme in ("loop", "tuned-loop"):
        for n in range(3, 10):
            points, faces = models.triangle_fan(n, 4)
            fine, triangles = make.refine(make.obj(f"fan_{n}", points, faces), scheme, 3, keep=False)
            p = Plane((250, 250), (-1, -1), (1, 1))
            for f in triangles:
                p.line([fine[v][:2] for v in f], INK, 0.9, closed=True)
            s.add(p.picture(), f"{scheme}, valence {n}\nlambda {make.scheme(scheme, n)['subdominant'][0]:.3f}")
    make.save(s, "uneven_rings")


@sheet
def tuned_loop(make):
    s = Sheet("Tuned Loop beside Loop", 4, (330, 320), "a ridge: even triangles against ripples, one parameter from Loop (0) to prescribed eigenvalues (1)")
    for n in (12, 24):
        control = make.obj(f"ridge_{n}", *ridge(n))
        for tuning in (0, 0.5, 1):
            fine = make.refine(control, "tuned-loop", 5, tuning)
            s.add(make.picture(*fine, (330, 320), camera="35,42", up="z"),
                  f"valence {n}, tuning {tuning}\n" + ("Loop" if tuning == 0 else ""))
        fine, triangles = make.refine(control, "tuned-loop", 3, 1, keep=False)
        p = Plane((330, 320), (-0.8, -0.8), (0.8, 0.8))
        for f in triangles:
            p.line([fine[v][:2] for v in f], INK, 1.0, closed=True)
        s.add(p.picture(), f"valence {n}, tuning 1, from above\n3 steps; Loop: see uneven_rings")
    make.save(s, "tuned_loop")


def fraction(x):
    for d in (1, 2, 4, 5, 8, 16, 20, 32, 64, 128, 256, 40, 80, 320):
        if abs(x * d - round(x * d)) < 1e-9:
            return f"{round(x * d)}/{d}" if d > 1 else f"{round(x)}"
    return f"{x:.3f}"


def mask_picture(points, terms, size, faces, new):
    """The points of a mask with their weights, and in red where the new point lies."""
    used = [points[v] for v in terms] + [new]
    low, high = [min(p[i] for p in used) for i in (0, 1)], [max(p[i] for p in used) for i in (0, 1)]
    reach = 0.5 * max(high[0] - low[0], high[1] - low[1], 1.5) + 0.35
    centre = [0.5 * (low[i] + high[i]) for i in (0, 1)]
    p = Plane((size, size), [c - reach for c in centre], [c + reach for c in centre])
    for f in faces:
        p.line([points[v][:2] for v in f], GREY, 1.2, closed=True)
    most = max(abs(w) for w in terms.values())
    for v, w in terms.items():
        p.dot(points[v], BLUE, 3 + 5 * math.sqrt(abs(w) / most))
    for v, w in terms.items():
        p.text(points[v], fraction(w), INK, 12, below=19)
    x, y = p.at(new)
    r = 9 * 3
    p.draw.ellipse((x - r, y - r, x + r, y + r), outline=RED, width=6)
    return p.picture()


@sheet
def factorization(make):
    s = Sheet("Stencils of dual schemes as products of simple steps", 6, (310, 310),
              "weights of one new point (red) at a regular face and at a 5-gon; each averaging step takes the means of the quads around")
    for corners in (4, 5):
        points, faces = models.face_fan(corners, 2)
        at = "regular" if corners == 4 else "5-gon"
        for scheme, option, caption in (("averaging", 0, "bilinear split\nthe face's point; edges: 1/2, 1/2"),
                                        ("averaging", 1, "1 averaging step\nDoo-Sabin, Catmull and Clark's weights"),
                                        ("doo-sabin", None, "Doo-Sabin\nDoo and Sabin's weights"),
                                        ("midedge-simplest", None, "midedge\ntwo rounds of midpoints"),
                                        ("averaging", 2, "2 averaging steps\nnearly Catmull-Clark"),
                                        ("averaging", 3, "3 averaging steps\nbiquartic")):
            # The weights of the new point are what it is of unit heights, one control point after the other.
            fine_points, _ = make.refine(make.obj("_plane", points, faces), scheme, 1, option, keep=False)
            corner = points[0]
            # The face's point; of two steps the vertex; else the child of the corner within the face.
            goal = 0 if option == 0 else 1 if option == 2 else 0.55
            target = min(range(len(fine_points)), key=lambda i: math.dist(fine_points[i][:2], [goal * c for c in corner[:2]]))
            terms = {}
            for v, q in enumerate(points):
                if math.hypot(*q[:2]) > 2.6:
                    continue
                raised = [(x, y, 1.0 if i == v else 0.0) for i, (x, y, _) in enumerate(points)]
                weight = make.refine(make.obj("_unit", raised, faces), scheme, 1, option, keep=False)[0][target][2]
                if abs(weight) > 1e-12:
                    terms[v] = weight
            s.add(mask_picture(points, terms, 310, faces, fine_points[target]), f"{at}: {caption}")
    make.save(s, "factorization")


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__ + "\nsheets: " + " ".join(SHEETS))
    make = Maker(sys.argv[1], sys.argv[2])
    for name in sys.argv[3:] or SHEETS:
        if name not in SHEETS:
            sys.exit(f"figures: no sheet is called {name}; there are: {' '.join(SHEETS)}")
        SHEETS[name](make)


if __name__ == "__main__":
    main()
