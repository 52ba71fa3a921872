#!/usr/bin/env python3
"""The standard comparisons of subdivision schemes as contact sheets, made by the program; see tools/figures.sh.

    tools/figures.py BUILD_DIR OUT_DIR [SHEET...]     names of sheets; without: all

Exit codes: 0 if all pictures are drawn, 77 if no Python with Pillow and the font DejaVu Sans is there, else 1.
"""
import os
import pathlib
import sys

MISSING = 77  # tests with this exit code are skipped

try:
    from PIL import ImageFont
    ImageFont.truetype("DejaVuSans.ttf", 12)
except (ImportError, OSError):
    # Debian's packages serve Debian's interpreter, which need not be the first one.
    debian = "/usr/bin/python3"
    if sys.executable != debian and os.path.exists(debian):
        os.execv(debian, [debian, *sys.argv])
    print("figures: no Python with Pillow and the font DejaVu Sans was found (python3-pil, fonts-dejavu-core)", file=sys.stderr)
    sys.exit(MISSING)

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
        picture = make.out / f"{name}.png"
        picture.unlink(missing_ok=True)
        SHEETS[name](make)
        if not picture.exists():
            sys.exit(f"figures: the sheet {name} has not written {picture}")


if __name__ == "__main__":
    main()
