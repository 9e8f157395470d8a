"""MuJoCo's shell on the square cantilever: one JSON object a configuration, on standard output.

    python mujoco_cantilever.py --grid 11 --grid 21 [--case cantilever|release] [--hz 60] [--membrane edges]

The sheet: 0.25 m square, 0.5 mm thick, E 3 GPa, Poisson ratio 0, 1050 kg/m3, clamped along one edge, let go from flat.
`cantilever` is damped and stepped until no mass moves faster than 1 mm/s for 0.5 s, 10 s at most; `release` has no damping
but the integrator's own and reports the first extreme of the free edge's mean, interpolated between steps, of 2 s.

What MuJoCo is told, and why:
- `flexcomp type="grid"`: its own triangulation, and its own bending from E, the Poisson ratio and the thickness (cotangent
  hinges with a constant stiffness). Nothing is fitted to this case.
- `--membrane elastic`: stretch from E too (`elastic2d="both"`), `solver="Newton"` (`CG` costs the same here). The engine's
  own model of the whole sheet. `--membrane edges`: bending only, and edges that keep their length as constraints
  (`elastic2d="bend"`, `edge equality`), as its own plate example has it, with `solver="CG"`, three to six times cheaper
  here than Newton. The constraint is set hard (`solimp` 0.99): with the default the sheet gives way more and more as the grid is
  refined (+14 % at 21, +18 % at 41 instead of +10.7 % at 21). Both are run: the second is cheaper and keeps a swing far
  better, the first is nearer at rest.
- The clamp lies halfway between two pinned rows, so N rows along the length are spaced L / (N - 1.5). That is where a hinge
  on the last pinned row puts it, and the kindest of three placings: with the clamp on the last pinned row the drop is 30 and
  20 % too large at 11 and 21.
- Free edges carry half, corners a quarter of an inner mass, so that the weight and its lever are right.
- `integrator="discrete"`, the only implicit one left for shells in 4.0; `tolerance` 1e-6 as in its own shell examples: 1e-8
  costs 10 to 20 % more for the same drop to four digits.
- The step is 1/60 s unless `--hz` says otherwise; 1/30 and 1/15 s are stable too and settle to the same drop.
- Damping (`elasticity damping`, stiffness-proportional) 0.05 s: a third of critical in the first mode, settles soonest.
- Contacts are off: nothing can touch.
CPU time is that of the process over `mj_step` alone, one thread.
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import json
import time

import mujoco
import numpy as np

from elastica import tip_drop

LENGTH, THICKNESS, YOUNG, DENSITY, GRAVITY = 0.25, 5e-4, 3e9, 1050.0, 9.81
REST_SPEED, REST_TIME, LONGEST, RELEASE_TIME = 1e-3, 0.5, 10.0, 2.0
DAMPING = 0.05  # s
TOLERANCE = 1e-6

# What stretches: solver, parts of elasticity, and the edges' own element.
MEMBRANES = {
    "elastic": ("Newton", "both", ""),
    "edges": ("CG", "bend", '<edge equality="true" solref="0.034 1" solimp="0.99 0.999 1e-5"/>'),
}

MODEL = """
<mujoco>
  <option timestep="{dt}" integrator="discrete" solver="{solver}" tolerance="{tolerance}" gravity="0 0 -{gravity}">
    <flag contact="disable"/>
  </option>
  <size memory="256M"/>
  <worldbody>
    <flexcomp name="sheet" type="grid" dim="2" count="{n} {n} 1" spacing="{along} {across} 1" pos="{centre} 0 0"
              mass="{mass}" radius="1e-4">
      <contact selfcollide="none"/>
      <elasticity young="{young}" poisson="0" thickness="{thickness}" damping="{damping}" elastic2d="{elastic}"/>
      {edge}
      <pin gridrange="0 0 1 {last}"/>
    </flexcomp>
  </worldbody>
</mujoco>
"""


def build(n, dt, damping, membrane):
    """The sheet of n x n masses, and the indices of the free edge's vertices."""
    along, across = LENGTH / (n - 1.5), LENGTH / (n - 1)
    solver, elastic, edge = MEMBRANES[membrane]
    inner = DENSITY * THICKNESS * along * across
    model = mujoco.MjModel.from_xml_string(MODEL.format(
        dt=dt, tolerance=TOLERANCE, gravity=GRAVITY, n=n, last=n - 1, along=along, across=across,
        centre=-0.5 * along + 0.5 * (n - 1) * along, mass=inner * n * n, young=YOUNG, thickness=THICKNESS, damping=damping,
        solver=solver, elastic=elastic, edge=edge))
    for vertex in range(model.nflexvert):
        row, column = divmod(vertex, n)
        body = model.flex_vertbodyid[vertex]
        if model.body_dofnum[body] > 0:
            share = (0.5 if row == n - 1 else 1.0) * (0.5 if column in (0, n - 1) else 1.0)
            model.body_mass[body] *= share
            model.body_inertia[body] *= share
    data = mujoco.MjData(model)
    mujoco.mj_setConst(model, data)
    mujoco.mj_forward(model, data)
    return model, data, slice((n - 1) * n, n * n)


def drop(data, edge):
    """How far the mean of the free edge hangs below the clamp, m."""
    return -float(data.flexvert_xpos[edge, 2].mean())


def settle(model, data):
    """Steps until at rest; CPU time, s, and whether it came to rest."""
    cpu, still = 0.0, 0.0
    dt = model.opt.timestep
    while data.time < LONGEST and still < REST_TIME:
        start = time.process_time()
        mujoco.mj_step(model, data)
        cpu += time.process_time() - start
        speed = np.sqrt((data.qvel.reshape(-1, 3) ** 2).sum(axis=1).max())
        if not np.isfinite(speed):
            return cpu, False
        still = still + dt if speed < REST_SPEED else 0.0
    return cpu, still >= REST_TIME


def first_extreme(model, data, edge):
    """Steps for RELEASE_TIME; CPU time, s, and drop, m, and time, s, of the first extreme, on a parabola through three steps."""
    cpu, dt = 0.0, model.opt.timestep
    drops = [drop(data, edge)]
    while data.time < RELEASE_TIME:
        start = time.process_time()
        mujoco.mj_step(model, data)
        cpu += time.process_time() - start
        # Vertex positions are those of the step's start.
        mujoco.mj_kinematics(model, data)
        mujoco.mj_flex(model, data)
        drops.append(drop(data, edge))
    for before, at, after in zip(drops, drops[1:], drops[2:]):
        if at >= after:
            shift = 0.5 * (before - after) / (before - 2.0 * at + after)
            return cpu, at - 0.25 * (before - after) * shift, (drops.index(at) + shift) * dt
    return cpu, None, None


def measure(case, n, hz, membrane):
    """The JSON object of one configuration."""
    model, data, edge = build(n, 1.0 / hz, DAMPING if case == "cantilever" else 0.0, membrane)
    found = {"peer": "MuJoCo shell", "version": mujoco.__version__, "case": case, "grid": n, "dt_s": model.opt.timestep,
             "label": "elastic membrane" if membrane == "elastic" else "rigid edges"}
    if case == "cantilever":
        cpu, settled = settle(model, data)
        mujoco.mj_forward(model, data)
        gamma = 12.0 * DENSITY * GRAVITY * LENGTH**3 / (YOUNG * THICKNESS**2)
        reference = tip_drop(gamma) * LENGTH
        own = {"drop_m": drop(data, edge), "reference_drop_m": reference, "error": drop(data, edge) / reference - 1.0,
               "settled": settled}
    else:
        cpu, depth, at = first_extreme(model, data, edge)
        own = {"first_extreme_m": depth, "first_extreme_s": at, "settled": None}
    return found | {"simulated_s": data.time, "cpu_ms_per_simulated_s": 1e3 * cpu / data.time} | own


def main():
    parser = argparse.ArgumentParser(description="MuJoCo's shell on the square cantilever")
    parser.add_argument("--grid", type=int, action="append", help="masses a side, 4 or more; may be repeated (11, 21)")
    parser.add_argument("--case", choices=["cantilever", "release"], default="cantilever")
    parser.add_argument("--hz", type=float, default=60.0, help="steps a second")
    parser.add_argument("--membrane", choices=MEMBRANES, default="elastic", help="stretch: elastic, or edges kept in length")
    options = parser.parse_args()
    for n in options.grid or [11, 21]:
        print(json.dumps(measure(options.case, n, options.hz, options.membrane)), flush=True)


if __name__ == "__main__":
    main()
