"""Surfaces of the schemes beside each other."""
import json
import math

from PIL import Image

import models
from maker import DATA, run, sheet
from sheet import Sheet


def limit_volume(make, path, scheme, level, control, digits):
    """Of the limit, as a percentage of the control mesh's, with those digits: the volumes of two levels extrapolated,
    as their error falls to a fourth by the level; from the next two as well, to see that the digits are right."""
    shares = [100 * models.volume(*make.refine(path, scheme, k, keep=False)) / models.volume(*control) for k in (level - 2, level - 1, level)]
    earlier, last = ((4 * b - a) / 3 for a, b in zip(shares, shares[1:]))
    while digits > 0 and abs(last - earlier) > 0.3 * 10 ** -digits:
        digits -= 1
    return f"{last:.{digits}f} %"


@sheet
def cube_and_tetrahedron(make):
    s = Sheet("Cube and tetrahedron under five schemes", 6, (300, 280),
              "in the outline of the control mesh (small ones also by themselves); volume as a share of the control mesh's")
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
    s = Sheet("A tetrahedron under Loop, level by level", 3, (400, 350), "each as large as it fits; volume as a share of the tetrahedron's")
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
    s.add(make.edges(*control, (420, 480), (25, 8)), f"control mesh\n{len(control[1])} faces")
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
    s = Sheet("A cube under the three dual schemes", 3, (420, 380),
              "in the outline of the control polyhedron; midedge and Doo-Sabin agree on parallelograms, and differ a little after the first step. Volumes are those of the limits")
    control = models.read_obj(DATA / "cube.obj")
    for scheme in ("midedge", "doo-sabin", "biquartic"):
        fine = make.refine(DATA / "cube.obj", scheme, 6)
        s.add(make.framed(control, fine, (420, 380)), f"{scheme}\nvolume {limit_volume(make, DATA / 'cube.obj', scheme, 7, control, 3)} of the cube's")
    make.save(s, "dual_schemes_cube")


@sheet
def pipe(make):
    s = Sheet("A three-legged pipe with boundary", 3, (420, 400), "no creases; the rims follow their own curves: cubic and quadratic B-spline, four-point")
    control = models.read_obj(DATA / "pipe3.obj")
    quads = make.obj("pipe3", *control)
    # Every quad from its first corner: the diagonals run the same way, and most vertices have valence 6.
    triangles = make.obj("pipe3_cut", control[0], [[f[0], f[i - 1], f[i]] for f in control[1] for i in range(2, len(f))])
    view = {"size": (420, 400), "camera": "35,35"}
    s.add(make.picture(*control, **view, flags=("--flat",)), f"control mesh\n{len(control[1])} faces")
    for scheme in ("loop", "modified-butterfly", "catmull-clark", "doo-sabin", "kobbelt"):
        cut = "after triangulation" if scheme in ("loop", "modified-butterfly") else ""
        s.add(make.picture(*make.refine(triangles if cut else quads, scheme, 4), **view),
              f"{scheme}\n" + ("interpolating " if scheme in ("modified-butterfly", "kobbelt") else "") + cut)
    make.save(s, "pipe")


@sheet
def extruded_pentagon(make):
    s = Sheet("An extruded pentagon and a simplified bunny", 3, (420, 380), "no creases; the pentagon in the outline of its control mesh")
    control = models.read_obj(DATA / "extruded_pentagon.obj")
    s.add(make.edges(*control, (420, 380)), f"control mesh\n{len(control[1])} faces")
    plain = make.obj("extruded_pentagon", *control)
    for scheme in ("catmull-clark", "doo-sabin"):
        fine = make.refine(plain, scheme, 5)
        s.add(make.framed(control, fine, (420, 380)), f"{scheme}\nvolume {100 * models.volume(*fine) / models.volume(*control):.1f} %")
    if bunny := make.bunny():
        control = models.read_obj(bunny)
        s.add(make.edges(*control, (420, 380), (10, 12)), f"control mesh\n{len(control[1])} faces")
        for scheme in ("catmull-clark", "doo-sabin"):
            s.add(make.picture(*make.refine(bunny, scheme, 4), (420, 380), camera="10,12"), f"{scheme}\n4 levels")
    make.save(s, "extruded_pentagon")
