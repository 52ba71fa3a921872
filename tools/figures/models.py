"""Control meshes as lists of points and faces, Wavefront files."""
import math


def read_obj(path):
    points, faces = [], []
    with open(path) as lines:
        for line in lines:
            word = line.split()
            if word[:1] == ["v"]:
                points.append(tuple(float(x) for x in word[1:4]))
            elif word[:1] == ["f"]:
                corners = [int(c.split("/")[0]) for c in word[1:]]
                faces.append([c - 1 if c > 0 else len(points) + c for c in corners])
    return points, faces


def write_obj(path, points, faces):
    with open(path, "w") as out:
        for p in points:
            out.write("v %.12g %.12g %.12g\n" % tuple(p))
        for f in faces:
            out.write("f " + " ".join(str(v + 1) for v in f) + "\n")
    return path


def volume(points, faces):
    six = 0
    for f in faces:
        for i in range(2, len(f)):
            a, b, c = points[f[0]], points[f[i - 1]], points[f[i]]
            six += (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]))
    return six / 6


def triangle_fan(valence, rings):
    """Rings of triangles around one vertex, in the plane; the middle is vertex 0."""
    points, number = [(0.0, 0.0, 0.0)], {}

    def vertex(s, a, b):
        if a == 0:
            s, a, b = s + 1, b, 0
        if a == 0:
            return 0
        key = (s % valence, a, b)
        if key not in number:
            number[key] = len(points)
            p, q = 2 * math.pi * s / valence, 2 * math.pi * (s + 1) / valence
            points.append((a * math.cos(p) + b * math.cos(q), a * math.sin(p) + b * math.sin(q), 0.0))
        return number[key]

    faces = []
    for s in range(valence):
        for a in range(rings):
            for b in range(rings - a):
                faces.append([vertex(s, a, b), vertex(s, a + 1, b), vertex(s, a, b + 1)])
                if a + b + 1 < rings:
                    faces.append([vertex(s, a + 1, b), vertex(s, a + 1, b + 1), vertex(s, a, b + 1)])
    return points, faces


def face_fan(corners, rings):
    """Rings of quads around one face, in the plane; its corners are the first vertices."""
    points, number = [], {}
    r = 0.5 / math.sin(math.pi / corners)

    def vertex(s, a, b):
        key = (s % corners, a, b)
        if key not in number:
            number[key] = len(points)
            t = 2 * math.pi / corners
            points.append((r * math.cos(s * t) + a * math.cos((s - 0.5) * t) + b * math.cos((s + 0.5) * t),
                           r * math.sin(s * t) + a * math.sin((s - 0.5) * t) + b * math.sin((s + 0.5) * t), 0.0))
        return number[key]

    faces = [[vertex(s, 0, 0) for s in range(corners)]]
    for s in range(corners):
        for a in range(1, rings + 1):
            faces.append([vertex(s - 1, 0, a - 1), vertex(s - 1, 0, a), vertex(s, a, 0), vertex(s, a - 1, 0)])
            for b in range(1, rings + 1):
                faces.append([vertex(s, a - 1, b - 1), vertex(s, a, b - 1), vertex(s, a, b), vertex(s, a - 1, b)])
    return points, faces
