#!/usr/bin/python3
"""Settle grains in a box, push one wall into them, and draw how they moved, their contacts, and the force on the wall.

    PYTHONPATH=PREFIX/LIBDIR/python3/dist-packages apps/embed/settle.py --grains 20000 --out settle.png
"""
import argparse

import numpy as np
import talus
from matplotlib.collections import EllipseCollection
from matplotlib.figure import Figure

SMALLEST, LARGEST = 0.8e-3, 1.2e-3  # [m] radii
WIDTH, ASPECT = 16e-3, 4.0          # [m] of the box along z, periodic; length of the bed (x) over its depth (y)
SPEED, PUSH = 0.04, 0.25            # [m/s] of the wall; how far it goes, over the depth


def settled(n, threads):
    """An engine with a bed at rest, its length, and the id of the wall that will move."""
    depth = np.sqrt(n * 7.2e-9 / (ASPECT * WIDTH))  # a grain takes some 7.2e-9 m^3 of a settled bed
    length, pitch = ASPECT * depth, 2.2 * LARGEST
    height = pitch * (n / (np.floor(length / pitch) * np.floor(WIDTH / pitch)) + 2)
    engine = talus.Engine(domain_lo=(-length, -LARGEST, 0), domain_hi=(2 * length, height + depth, WIDTH), periodic=(0, 0, 1),
                          time_step=1e-6, threads=threads)
    sand = engine.add_material(young=2e6, poisson=0.25, density=2650)
    engine.set_contact(sand, sand, restitution=0.4, friction=0.6, rolling_friction=0.1)
    engine.add_wall(material=sand, point=(0, 0, 0), normal=(0, 1, 0))
    engine.add_wall(material=sand, point=(length, 0, 0), normal=(-1, 0, 0))
    moving = engine.add_wall(material=sand, point=(0, 0, 0), normal=(1, 0, 0))
    engine.fill(material=sand, lo=(0, 0, 0), hi=(length, height, WIDTH), radius_min=SMALLEST, radius_max=LARGEST, count=n)
    engine.set_time_step(0.2 * engine.critical_step())
    lift = 9.81 * engine.gather("mass").sum() * LARGEST  # [J] that raises all grains by a radius
    while engine.step(500) and (engine.state().kinetic_energy > 1e-3 * lift or engine.state().contacts < n):
        pass
    return engine, length, moving


def coordination(engine):
    """Touching grains of each grain. Along x no partner is farther than a diameter: as many shifts of the sorted list do."""
    x, r = engine.gather("position"), engine.gather("radius")
    order = np.argsort(x[:, 0])
    x, r, count = x[order], r[order], np.zeros(len(x), int)
    for k in range(1, len(x)):
        apart = x[k:] - x[:-k]
        if apart[:, 0].min() > 2 * LARGEST:
            break
        apart[:, 2] -= WIDTH * np.round(apart[:, 2] / WIDTH)
        touch = (apart**2).sum(axis=1) < (r[k:] + r[:-k])**2
        count[k:] += touch
        count[:-k] += touch
    return count


def picture(path, engine, before, after, pushed, force):
    """The bed from the side, coloured by how far grains have moved; the two histograms; the force."""
    figure = Figure(figsize=(10, 7), layout="constrained")
    bed, bars, curve = figure.subplot_mosaic([["bed", "bed"], ["bars", "curve"]], height_ratios=[1, 1.1]).values()
    x, r = engine.gather("position") * 1e3, engine.gather("radius") * 2e3
    front = np.argsort(-x[:, 2])[-len(x) // 4:]  # a slice, the nearest last
    grains = bed.add_collection(EllipseCollection(
        r[front], r[front], 0 * r[front], units="xy", offsets=x[front, :2], transOffset=bed.transData, edgecolors="k", linewidths=0.15,
        array=np.linalg.norm(engine.gather("displacement")[front], axis=1) * 1e3, clim=(0, pushed[-1])))
    bed.axvline(pushed[-1], color="tab:red", lw=3)
    bed.set(aspect="equal", xlim=(-2, x[:, 0].max() + 2), ylim=(0, x[:, 1].max() + 2), xlabel="x [mm]", ylabel="y [mm]",
            title=f"{len(x):,} grains after the wall (red) has been pushed in by {pushed[-1]:.1f} mm")
    figure.colorbar(grains, ax=bed, label="moved [mm]", pad=0.01)
    numbers = np.arange(max(before.max(), after.max()) + 1)
    for counts, offset, colour, label in ((before, -0.2, "0.65", "settled"), (after, 0.2, "tab:blue", "pushed")):
        bars.bar(numbers + offset, np.bincount(counts, minlength=len(numbers)) / len(counts) * 100, 0.4, color=colour, label=f"{label}, mean {counts.mean():.2f}")
    bars.set(xlabel="grains in touch with a grain", ylabel="share of grains [%]", title="Coordination number", xticks=numbers)
    bars.legend(frameon=False)
    liquid = 9.81 * engine.gather("mass").sum() * x[:, 1].mean() / np.ptp(x[:, 0])  # [N] rho g h^2 / 2 over the width
    curve.plot(pushed, force, color="tab:red", lw=1.2)
    curve.axhline(liquid, color="0.5", ls="--", lw=1)
    curve.annotate("a liquid of that weight", (pushed[-1], liquid), (0, 4), textcoords="offset points", ha="right", color="0.4")
    curve.set(xlabel="wall pushed in by [mm]", ylabel="force on the wall [N]", title="Push of the grains", xlim=(0, pushed[-1]), ylim=(0, None))
    for axes in (bed, bars, curve):
        axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(path, dpi=130)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    for name, value in (("grains", 20000), ("threads", 2), ("out", "settle.png")):
        parser.add_argument(f"--{name}", type=type(value), default=value, help="default %(default)s")
    given = parser.parse_args()
    engine, length, moving = settled(given.grains, given.threads)
    with engine:
        print(f"{engine.state().particles} grains at rest after {engine.state().step} steps")
        engine.mark_reference()
        engine.set_wall_velocity(moving, (SPEED, 0, 0))
        before, pushed, force = coordination(engine), [], []
        while not pushed or pushed[-1] < PUSH * length / ASPECT:
            pushed.append(engine.wall(moving).point[0])
            force.append(-engine.wall(moving).force[0])
            engine.step(50)
        state, after = engine.state(), coordination(engine)
        print(f"{state.contacts} contacts, {after.sum() // 2} by distance, after {pushed[-1] * 1e3:.1f} mm; digest {state.digest}")
        picture(given.out, engine, before, after, np.array(pushed) * 1e3, np.array(force))
