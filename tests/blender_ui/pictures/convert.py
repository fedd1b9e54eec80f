# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the documents' pictures of what picture_*.py have taken; runs in a Python that has Pillow.

    python convert.py TAKEN IMAGES

Frames become pull.webp, every other NAME.png becomes NAME.webp in the folder IMAGES.
"""

from __future__ import annotations

import sys
from pathlib import Path

from PIL import Image

MOVING_WIDTH = 640  # pixels
WIDEST = 900
PANEL_PIXELS = 90_000  # up to here a picture is kept exact, as panels are


def moving(frames: list[Path], out: Path) -> None:
    """One picture that moves."""
    images = [Image.open(path).convert("RGB") for path in frames]
    size = (MOVING_WIDTH, round(MOVING_WIDTH * images[0].height / images[0].width))
    first, *rest = [image.resize(size, Image.Resampling.LANCZOS) for image in images]
    first.save(out, save_all=True, append_images=rest, duration=80, loop=0, quality=60, method=6)


def still(path: Path, out: Path) -> None:
    """Letters of a panel stay sharp; a view is made small."""
    image = Image.open(path).convert("RGB")
    if image.width * image.height <= PANEL_PIXELS:
        image.save(out, "WEBP", lossless=True, quality=60, method=4)
        return
    if image.width > WIDEST:
        image = image.resize((WIDEST, round(WIDEST * image.height / image.width)), Image.Resampling.LANCZOS)
    image.save(out, "WEBP", quality=82, method=4)


def main() -> None:
    taken, images = map(Path, sys.argv[1:])
    frames = sorted(taken.glob("frame_*.png"))
    if frames:
        moving(frames, images / "pull.webp")
    for path in sorted(set(taken.glob("*.png")) - set(frames)):
        still(path, images / f"{path.stem}.webp")
        print(f"pictures: {path.stem}.webp, {(images / f'{path.stem}.webp').stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main()
