"""Finds the Young's modulus at which a sheet of a running game droops by a measured amount.

    sheetwork serve assets/scenes/cantilever_sheet.ron &
    python calibrate.py --droop 0.02          # m below the highest point, at rest

The droop of a clamped sheet decreases with its stiffness, approximately as a power of it. The
search is a secant method (regula falsi, Illinois variant) on logarithms, between two enclosing
moduli. After each change this program steps the game until the droop is constant, with additional
damping, which does not affect the equilibrium.
"""

import argparse
import math

import sheetwork


def droop_at(game, sheet, young, patience):
    """Droop (m) at rest with this Young's modulus (Pa)."""
    game.set(f"sheets.{sheet}.material.young", young)
    dt = game.status()["dt"]
    burst = max(1, round(0.25 / dt))
    previous, still, waited = None, 0, 0.0
    while waited < patience:
        game.step(burst)
        waited += burst * dt
        heights = game.frame().sheet(sheet).positions[:, 1]
        droop = float(heights.max() - heights.min())
        still = still + 1 if previous is not None and abs(droop - previous) < 1e-6 + 1e-4 * droop else 0
        if still >= 3:
            return droop
        previous = droop
    return previous


def calibrate(game, sheet, wanted, low, high, tolerance=1e-3, patience=20.0, say=print):
    """Young's modulus (Pa) between `low` and `high` at which the sheet droops by `wanted` (m), to a
    relative `tolerance`.
    """

    def miss(exponent):
        droop = droop_at(game, sheet, math.exp(exponent), patience)
        say(f"E = {math.exp(exponent):.4e} Pa: droop {1e3 * droop:.3f} mm")
        return math.log(max(droop, 1e-12) / wanted)

    a, b = math.log(low), math.log(high)
    fa, fb = miss(a), miss(b)
    if fa < 0 or fb > 0:
        largest, least = 1e3 * wanted * math.exp(fa), 1e3 * wanted * math.exp(fb)
        raise SystemExit(f"between {low:g} and {high:g} Pa the sheet droops {least:.2f} to {largest:.2f} mm")
    kept = 0
    for _ in range(30):
        c = (a * fb - b * fa) / (fb - fa)
        fc = miss(c)
        if abs(fc) <= tolerance:
            break
        # An end that is kept twice in a row counts half, so that it moves too.
        if fc > 0:
            a, fa = c, fc
            fb, kept = (fb / 2, 1) if kept == 1 else (fb, 1)
        else:
            b, fb = c, fc
            fa, kept = (fa / 2, -1) if kept == -1 else (fa, -1)
    return math.exp(c)


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--link", default="", help="name of the link")
    arguments.add_argument("--sheet", help="name of the sheet; the first if left out")
    arguments.add_argument("--droop", type=float, required=True, help="measured droop, m")
    arguments.add_argument("--low", type=float, default=1e8, help="smallest Young's modulus to try, Pa")
    arguments.add_argument("--high", type=float, default=1e11, help="largest Young's modulus to try, Pa")
    options = arguments.parse_args()
    for name in ("droop", "low", "high"):
        value = getattr(options, name)
        if not 0.0 < value < math.inf:
            arguments.error(f"--{name} {value}: must be a number above 0")
    with sheetwork.attach(options.link, wait=5.0) as game:
        game.patience = 60.0
        sheet = options.sheet or game.status()["sheets"][0]
        damping = f"sheets.{sheet}.damping_ratio"
        before = game.set(damping, 0.7)
        try:
            found = calibrate(game, sheet, options.droop, options.low, options.high)
        finally:
            game.set(damping, before)
        print(f"sheets.{sheet}.material.young = {found:.4e} Pa")


if __name__ == "__main__":
    main()
