"""The layer rule: no include points up, between layers or between the folders of one (README.md of each layer).

Programs that stand for users (tools/tetrakis, tools/examples, tools/viewer, tests/contract) include public headers only, but for
tools/tetrakis/schemes, which draws what schemes are made of. Above schemes/ nobody asks which scheme it is: what differs
is a field of SchemeInfo. Each folder has a README.md with its name as the title.
Usage: layers.py SOURCE_DIR; prints every arrow that points up and what else is wrong, and fails if there is any.
"""
import os
import re
import sys

# From the bottom up. A folder may include itself and what stands before it in its list.
LAYERS = {
    "schemes": ["core", "parts", "rules", "analysis", "curves"],
    "hier": ["base", "mesh", "obj", "forest", "trees"],
    "refine": ["rules", "attributes", "lattices", "uniform", "points", "families", "adaptive", "factored"],
    "eval": ["surface", "triangles", "patches", "bounds", "distance", "estimate", "io", "tessellate",
             "terrain", "lod_surfaces", "lod_terrain", "lod", "render"],
}
KNOWS = {"schemes": ["schemes"], "hier": ["hier"], "refine": ["schemes", "hier", "refine"]}
KNOWS["eval"] = KNOWS["refine"] + ["eval"]
USERS = ["tools/tetrakis", "tools/capi", "tools/examples", "tools/viewer", "tests/contract"]
INSIDERS = ["tools/tetrakis/schemes"]


def sources(root, folder):
    for path, _, names in os.walk(os.path.join(root, folder)):
        for name in sorted(names):
            if name.endswith((".hpp", ".cpp", ".inc")):
                yield os.path.relpath(os.path.join(path, name), root)


def includes(root, source):
    with open(os.path.join(root, source), encoding="utf-8") as file:
        for target in re.findall(r'^\s*#\s*include "([^"]+)"', file.read(), re.M):
            yield os.path.normpath(os.path.join(os.path.dirname(source), target))


def public_headers(root):
    result = set()
    for layer in LAYERS:
        with open(os.path.join(root, layer, "CMakeLists.txt"), encoding="utf-8") as file:
            listed = re.search(r"PUBLIC_HEADERS([^)]*)\)", file.read()).group(1)
        result.update(layer + "/" + header for header in listed.split())
    return result


def fault(root, public, source, target):
    """What is wrong with source's including target, or None."""
    if not os.path.exists(os.path.join(root, target)):
        return "no such file"
    here, there = source.split("/"), target.split("/")
    if here[0] not in LAYERS:
        within = lambda folders: any(source.startswith(folder + "/") for folder in folders)
        users = within(USERS) and not within(INSIDERS)
        return "not a public header" if users and there[0] in LAYERS and target not in public else None
    if there[0] not in KNOWS[here[0]]:
        return f"{here[0]} does not know {there[0]}"
    if len(here) == 2:
        return None
    order = LAYERS[here[0]]
    if here[1] not in order:
        return f"no place in the order of {here[0]}"
    if here[0] == there[0] and (there[1] not in order or order.index(there[1]) > order.index(here[1])):
        return "points up"
    if source in public and target not in public:
        return "a public header includes one that is not installed"
    return None


ASKS_WHICH = re.compile(r"scheme\w*(?:\(\)|\.info\(\))?\.(?:name\(?\)?|step) *[!=]= *[\w\"]")


def names_asked(root, source):
    """Lines that compare the name or the function of a scheme."""
    with open(os.path.join(root, source), encoding="utf-8") as file:
        return [number for number, line in enumerate(file, 1) if ASKS_WHICH.search(line)]


def untitled(root):
    """The folders without a README.md that begins with their name."""
    for layer, folders in LAYERS.items():
        for folder in [layer] + [f"{layer}/{name}" for name in folders]:
            readme = os.path.join(root, folder, "README.md")
            if not os.path.exists(readme) or not open(readme, encoding="utf-8").readline().startswith(f"# {folder}:"):
                yield f"{readme}: not begun with '# {folder}: ...'"


def main():
    root = sys.argv[1]
    public = public_headers(root)
    faults = list(untitled(root))
    for folder in list(LAYERS) + USERS:
        for source in sources(root, folder):
            for target in includes(root, source):
                what = fault(root, public, source, target)
                if what:
                    faults.append(f"{source} -> {target}: {what}")
            if folder not in ("schemes", "tests/contract"):
                faults += [f"{source}:{line}: asks which scheme it is" for line in names_asked(root, source)]
    print("\n".join(faults) if faults else "no arrow points up")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
