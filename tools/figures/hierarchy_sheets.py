"""Factored schemes and adaptive hierarchies."""
import json
import math

from PIL import Image, ImageSequence

import models
from maker import DATA, run, sheet
from sheet import BLUE, INK, ORANGE, Plane, Sheet

LEVEL_COLOURS = [(255, 255, 255), (247, 240, 226), (222, 233, 244), (222, 238, 218), (247, 222, 214), (232, 222, 242), (218, 240, 240)]


def window(points, size, share=1.0, centre=None):
    low, high = [min(p[i] for p in points) for i in (0, 1)], [max(p[i] for p in points) for i in (0, 1)]
    middle = centre or [0.5 * (low[i] + high[i]) for i in (0, 1)]
    reach = [0.52 * share * (high[i] - low[i]) for i in (0, 1)]
    return Plane(size, [middle[i] - reach[i] for i in (0, 1)], [middle[i] + reach[i] for i in (0, 1)])


def flat_mesh(p, mesh, width=1.2, colour=INK):
    """Faces in the colours of their levels."""
    for f, level in zip(mesh["faces"], mesh["levels"]):
        p.polygon([mesh["points"][v] for v in f], LEVEL_COLOURS[level % len(LEVEL_COLOURS)])
    for f in mesh["faces"]:
        p.line([mesh["points"][v] for v in f], colour, width, closed=True)
    return p.picture()


def adaptive(make, control, scheme, level, spot, radius, form=None, out="-"):
    return json.loads(run(make.tool, "adaptive", control, scheme, level, ",".join(f"{x:.17g}" for x in spot), radius, out, *([form] if form else [])))


# --- factored schemes -----------------------------------------------------------------------------------------------


@sheet
def half_steps(make):
    s = Sheet("Half-steps on the 4-8 mesh: primal cycle, bisection, dual cycle", 5, (300, 300),
              "a 5-gon and the quads around it; blue: the scheme's own mesh, grey: the other edges of the 4-8 mesh; dots: active vertices")
    control = make.obj("_plane", *models.face_fan(5, 1))
    captions = {"catmull-clark": ("control faces", "face and corner rule", "edge rule: one whole step", "face and corner rule", "edge rule: two whole steps"),
                "4-8": ("tetrakis mesh", "first 4-8 step: edges of blocks", "second 4-8 step: middles of blocks", "edges again", "middles again"),
                "doo-sabin": ("tetrakis mesh: blocks' centres rest", "midpoints of edges", "corner points: one whole step", "midpoints of edges", "corner points: two whole steps")}
    for scheme, texts in captions.items():
        for steps, text in enumerate(texts):
            p = window(models.face_fan(5, 1)[0], (300, 300))
            points, faces, inactive = make.factored(control, scheme, steps)
            for f in faces:
                p.line([points[v] for v in f], (170, 178, 190), 1.1, closed=True)
            own_points, own_faces, _ = make.factored(control, scheme, steps, "--active")
            for f in own_faces:
                p.line([own_points[v] for v in f], BLUE, 1.7, closed=True)
            for v, point in enumerate(points):
                if v not in inactive:
                    p.dot(point, ORANGE, 3 - 0.4 * steps)
            own = "" if steps % 2 == 0 or scheme == "4-8" else "blue: still the last whole step"
            s.add(p.picture(), f"{scheme}, {steps} half-step{'' if steps == 1 else 's'}\n{text}\n{own}")
    make.save(s, "half_steps")


@sheet
def factored_models(make):
    s = Sheet("Factored Catmull-Clark and Doo-Sabin", 5, (400, 400),
              "three half-steps: the 4-8 mesh as it is then; three whole steps: six of them. All vertices of the 4-8 mesh, for Doo-Sabin with those at rest")
    pentagon = make.obj("extruded_pentagon", *models.read_obj(DATA / "extruded_pentagon.obj"))
    for name, path, camera in (("extruded pentagon", pentagon, (32, 20)), ("simplified bunny", make.bunny(), (10, 12))):
        if path is None:
            continue
        points, faces = models.read_obj(path)
        s.add(make.edges(points, faces, (400, 400), camera), f"{name}\n{len(faces)} faces")
        for scheme in ("catmull-clark", "doo-sabin"):
            for steps, text in ((3, "three half-steps"), (6, "three whole steps")):
                out = make.meshes / f"{path.stem}_{scheme}_factored_{steps}.glb"
                plain = make.work / "_factored.obj"
                for target in (out, plain):
                    run(make.build / "tetrakis", "refine", path, "--factored", "--scheme", scheme, "--steps", steps, "-o", target)
                mesh = models.read_obj(plain)
                s.add(make.picture(*mesh, (400, 400), camera="%g,%g" % camera, flags=("--flat", "--wireframe") if steps == 3 else ("--wireframe",) if name != "simplified bunny" else ()),
                      f"{scheme}, {text}\n{len(mesh[1])} triangles")
    make.save(s, "factored_models")


def near_half_steps(make, path, scheme, steps, spot, radius):
    """The mesh of `refine --factored --near`, and its inactive vertices."""
    return make.factored(path, scheme, steps, "--near", ",".join(f"{x:.17g}" for x in spot), "--radius", radius)


@sheet
def adaptive_half_steps(make):
    s = Sheet("Half-steps that adapt: the restricted 4-8 mesh", 4, (400, 400),
              "as many half-steps as asked for inside of the circle or sphere, fewer outside, one half-step between neighbours; orange: active vertices, grey: at rest")
    control = make.obj("_plane", *models.face_fan(5, 1))
    spot, radius = models.face_fan(5, 1)[0][0], 0.3
    for scheme in ("catmull-clark", "doo-sabin"):
        for steps in (4, 7):
            points, faces, resting = near_half_steps(make, control, scheme, steps, spot, radius)
            p = window(points, (400, 400))
            for f in faces:
                p.line([points[v] for v in f], (110, 120, 135), 1.0, closed=True)
            p.line([(spot[0] + radius * math.cos(math.pi * i / 60), spot[1] + radius * math.sin(math.pi * i / 60)) for i in range(120)], BLUE, 1.6, closed=True)
            for v, point in enumerate(points):
                p.dot(point, (170, 178, 190) if v in resting else ORANGE, 3 - 0.2 * steps)
            s.add(p.picture(), f"{scheme}, {steps} half-steps\nabout a corner of a 5-gon\n{len(faces)} triangles, {len(resting)} of {len(points)} vertices at rest")
    for scheme, spot in (("catmull-clark", (0.5, 0.5, 0.5)), ("doo-sabin", (0.667, 0.667, 0.667))):
        for steps in (6, 11):
            points, faces, _ = near_half_steps(make, DATA / "cube.obj", scheme, steps, spot, 0.1)
            s.add(make.picture(points, faces, (400, 400), camera="32,25", flags=("--flat", "--wireframe")),
                  f"{scheme}, {steps} half-steps\nabout a corner of a cube\n{len(faces)} triangles")
    make.save(s, "adaptive_half_steps")


# --- adaptive hierarchies -------------------------------------------------------------------------------------------


@sheet
def transitions(make):
    s = Sheet("A transition of resolution in each family", 5, (360, 360),
              "colours: levels. Above: in the plane, at an extraordinary vertex or face; below: on a surface, in triangles")
    quads, fan = make.obj("_quads", *models.face_fan(5, 1)), make.obj("_fan", *models.triangle_fan(5, 2))
    corner = models.face_fan(5, 1)[0][0]
    for scheme, control, level, spot, radius, form, text in (
            ("catmull-clark", quads, "1:3", corner, 0.6, "quads", "Catmull-Clark: a restricted quadtree\ntriangles: the cells that the bisection closes"),
            ("loop", fan, "0:3", (0, 0, 0), 0.55, None, "Loop: red-green triangles\ngreen ones close the hanging midpoints"),
            ("doo-sabin", quads, "1:3", corner, 0.6, None, "Doo-Sabin: vertex quadtrees\na dual mesh: no cracks, only other faces"),
            ("sqrt3", fan, "0:4", (0, 0, 0), 0.4, None, "sqrt(3): Kobbelt's rule\nedges flip where both sides are split"),
            ("4-8", quads, "1:3", corner, 0.6, None, "4-8: bisection\nof diamonds, native")):
        mesh = adaptive(make, control, scheme, level, spot, radius, form)
        s.add(flat_mesh(window(mesh["points"], (360, 360)), mesh), text)
    for scheme, path, level, form in (
            ("catmull-clark", DATA / "cube.obj", "2:5", None),
            ("loop", DATA / "tetrahedron.obj", "2:5", None),
            ("doo-sabin", DATA / "cube.obj", "2:5", "triangles"),
            ("sqrt3", DATA / "tetrahedron.obj", "2:7", None),
            ("4-8", DATA / "cube.obj", "2:5", None)):
        make.refine(path, scheme, 3, keep=False)
        points, _ = models.read_obj(make.work / f"{path.stem}_{scheme}_3.obj")
        reach = max(math.dist(p, q) for p in points[:60] for q in points[:60])
        # The point of the surface that looks most towards the eye.
        eye = (math.sin(math.radians(32)) * math.cos(math.radians(20)), math.sin(math.radians(20)), math.cos(math.radians(32)) * math.cos(math.radians(20)))
        near = max(points, key=lambda p: sum(a * b for a, b in zip(p, eye)))
        mesh = adaptive(make, path, scheme, level, near, 0.22 * reach, form, make.meshes / f"{path.stem}_{scheme}_adaptive.glb")
        s.add(make.picture(mesh["points"], mesh["faces"], (360, 360), flags=("--wireframe",)),
              f"{scheme}: {path.stem}, adaptive\n{len(mesh['faces'])} triangles")
    make.save(s, "transitions")


@sheet
def adaptive_dual(make):
    s = Sheet("Adaptive dual meshes", 3, (460, 520), "a head: level 3 at the nose, level 1 elsewhere; faces as they are, and in triangles of the 4-8 pattern")
    points, faces = models.read_obj(DATA / "head.obj")
    path = make.obj("head_plain", points, faces)
    spot = max(points, key=lambda p: p[2] + 0.3 * p[0])
    reach = max(p[1] for p in points) - min(p[1] for p in points)
    for scheme in ("doo-sabin", "midedge"):
        for form, text in ((None, "the dual mesh"), ("triangles", "in triangles, 4-8 pattern")):
            if scheme == "midedge" and form:
                continue
            mesh = adaptive(make, path, scheme, "1:3", spot, 0.16 * reach, form,
                            make.meshes / f"head_{scheme}_adaptive{'_triangles' if form else ''}.glb")
            s.add(make.edges(mesh["points"], mesh["faces"], (460, 520), (25, 8)), f"{scheme}, {text}\n{len(mesh['points'])} vertices, {len(mesh['faces'])} faces")
    make.save(s, "adaptive_dual")


@sheet
def zoom(make):
    s = Sheet("25 levels in one place: one zoom in each kind of tree", 5, (320, 320),
              "a head, seen along its normal there; colours: levels, seven in turn. Leaves are only where the refinement is")
    plain = make.obj("head_plain", *models.read_obj(DATA / "head.obj"))
    # A step of sqrt3 shrinks by the root of 3.
    for scheme, powers in (("catmull-clark", (0, 3, 9, 17, 24)), ("loop", (0, 3, 9, 17, 24)), ("doo-sabin", (0, 3, 9, 17, 24)), ("sqrt3", (0, 3, 7, 13, 19))):
        data = json.loads(run(make.tool, "zoom", plain, scheme, 25, 100))
        points = data["points"]
        size = max(max(abs(q[0]), abs(q[1])) for q in points)
        for power in powers:
            reach = 1.04 * size / 2 ** power
            p = Plane((320, 320), (-reach, -reach), (reach, reach))
            inside = [i for i, f in enumerate(data["faces"]) if any(max(abs(points[v][0]), abs(points[v][1])) < 40 * reach for v in f)]
            # Towards the eye: not what the head hides.
            facing = [i for i in inside if sum(points[a][0] * points[b][1] - points[b][0] * points[a][1] for a, b in zip(data["faces"][i], data["faces"][i][1:] + data["faces"][i][:1])) > 0]
            for i in sorted(facing, key=lambda i: sum(points[v][2] for v in data["faces"][i]) / len(data["faces"][i])):
                corners = [points[v] for v in data["faces"][i]]
                p.polygon(corners, LEVEL_COLOURS[data["levels"][i] % len(LEVEL_COLOURS)])
                p.line(corners, INK, 1.1 if power else 0.7, closed=True)
            text = f"{data['leaves']} leaves; unrefined: {data['roots']}" if power == 0 else ""
            s.add(p.picture(), f"{scheme}, magnified {2 ** power:,}\n{text}")
    make.save(s, "zoom")


# --- view-dependent LOD ---------------------------------------------------------------------------------------------


@sheet
def flight(make):
    """The README's flight: what the program writes, and a tenth of its size as WebP."""
    folder = make.work / "flight"
    run(make.build / "tetrakis", "lod", DATA / "island.png", "--scale", 0.1, "--spacing", 40, "--frames", 48, "--images", 48,
        "--size", "480x270", "-o", folder)
    (folder / "flight.png").replace(make.out / "flight.png")
    with Image.open(make.out / "flight.png") as film:
        frames = [frame.convert("RGB") for frame in ImageSequence.Iterator(film)]
        frames[0].save(make.out / "flight.webp", save_all=True, append_images=frames[1:], duration=round(film.info["duration"]), loop=0,
                       quality=80, method=6)
    print(make.out / "flight.webp", flush=True)
