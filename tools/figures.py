#!/usr/bin/env python3
"""The standard comparisons of subdivision schemes as contact sheets, made by the program; see tools/figures.sh.

    tools/figures.py BUILD_DIR OUT_DIR [SHEET...]     names of sheets; without: all
"""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent / "figures"))
import plane_sheets  # noqa: E402, F401
import surface_sheets  # noqa: E402, F401
import mask_sheets  # noqa: E402, F401
import hierarchy_sheets  # noqa: E402, F401
from maker import SHEETS, Maker  # noqa: E402


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
