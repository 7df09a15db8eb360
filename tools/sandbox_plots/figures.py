"""The pictures. Lengths are in mm; colours are told apart by lightness too, not by hue alone."""
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import EllipseCollection
from matplotlib.colors import LinearSegmentedColormap, ListedColormap
from matplotlib.patches import Polygon, Rectangle

from .bands import LEFT, RIGHT
from .measure import surface

MM = 1e3
# Neighbours differ strongly in lightness, so that the layers stay apart in grey and for every kind of colour vision.
LAYERS = ListedColormap(["#f3e9d2", "#3b5b92", "#e3b23c", "#7a3b2e", "#a9cbe0", "#2f4a3c"])
# From paper white, so that sand at rest is quiet and bands stand out dark.
SHEAR = LinearSegmentedColormap.from_list("shear", ["#fbf8f1", "#f6d58e", "#ee8f4a", "#c0395b", "#6a1d6e", "#1d0f3c"])
# Orange and blue keep their difference for colour-blind eyes. Clockwise (dips left) is orange.
SPIN = LinearSegmentedColormap.from_list("spin", ["#7f3b08", "#e08214", "#fbf8f1", "#4a90c2", "#0b3c6f"])
BAND = {RIGHT: "#1565a8", LEFT: "#c25e00"}

plt.rcParams.update({
    "font.size": 9, "axes.titlesize": 9.5, "axes.titlelocation": "left", "axes.linewidth": 0.6, "axes.edgecolor": "#555555",
    "xtick.color": "#333333", "ytick.color": "#333333", "xtick.major.width": 0.6, "ytick.major.width": 0.6,
    "legend.frameon": False, "figure.facecolor": "white", "savefig.dpi": 160,
})


class Frame:
    """The stretch of the x-y plane all panels of a figure show, in mm, and the size of such panels."""

    width = 11.0      # inches of a panel's axes
    left, right, bottom, top, gap = 0.62, 0.25, 0.5, 0.45, 0.42
    headroom = 0.2    # above the highest sand, as a share of the bed's height: for what is written there

    def __init__(self, run, bar=0.0):
        diameter = MM * run.diameter
        low = min(float(snapshot.x.min()) for snapshot in run.snapshots)
        high = max(float(snapshot.x.max()) for snapshot in run.snapshots)
        peak = max(float(np.nanmax(surface(snapshot, run.diameter, run.depth)[1])) for snapshot in run.snapshots)
        base = min(float(snapshot.y.min()) for snapshot in run.snapshots)
        pad = 0.012 * MM * (high - low)
        self.x = (MM * low - pad - diameter, MM * high + pad + diameter)
        self.y = (MM * base - 0.8 * pad, MM * peak + self.headroom * MM * (peak - base))
        self.panel = self.width * (self.y[1] - self.y[0]) / (self.x[1] - self.x[0])
        self.right = self.right + bar

    def figure(self, panels, head=0.0):
        """A figure of so many panels, one above the other; equal scales on both axes by construction."""
        width = self.left + self.width + self.right
        height = self.bottom + panels * self.panel + (panels - 1) * self.gap + self.top + head
        figure = plt.figure(figsize=(width, height))
        axes = []
        for index in range(panels):
            y = height - head - self.top - (index + 1) * self.panel - index * self.gap
            ax = figure.add_axes([self.left / width, y / height, self.width / width, self.panel / height])
            ax.set(xlim=self.x, ylim=self.y, ylabel="y (mm)")
            ax.set_yticks(np.arange(0, self.y[1], 10 if self.y[1] > 15 else 5))
            ax.tick_params(labelbottom=index == panels - 1, length=3)
            axes.append(ax)
        axes[-1].set_xlabel("x (mm)")
        return figure, axes

    def colour_bar(self, figure, axes, image, label):
        width, _ = figure.get_size_inches()
        top, bottom = axes[0].get_position().y1, axes[-1].get_position().y0
        middle, half = 0.5 * (top + bottom), min(0.5 * (top - bottom), 2.2 / figure.get_size_inches()[1])
        where = figure.add_axes([(self.left + self.width + 0.15) / width, middle - half, 0.13 / width, 2 * half])
        bar = figure.colorbar(image, cax=where)
        bar.outline.set_linewidth(0.5)
        bar.set_label(label)


def draw_walls(ax, run, time):
    """Front wall, back stop and floor as grey bars outside of the sand."""
    (x_low, x_high), (y_low, y_high) = ax.get_xlim(), ax.get_ylim()
    names = run.walls.names()
    front = MM * run.wall_x("front", time) if "front" in names else x_low
    back = MM * run.wall_x("backstop", time) if "backstop" in names else x_high
    style = {"facecolor": "#8d8d8d", "edgecolor": "none", "zorder": 0}
    ax.add_patch(Rectangle((x_low, y_low), max(0.0, front - x_low), y_high - y_low, **style))
    ax.add_patch(Rectangle((back, y_low), max(0.0, x_high - back), y_high - y_low, **style))
    if "floor" in names:
        floor = MM * float(np.interp(time, run.walls.time, run.walls.point("floor", "y")))
        ax.add_patch(Rectangle((x_low, y_low), x_high - x_low, max(0.0, floor - y_low), **style))


def draw_grains(ax, snapshot):
    """Grains as discs of their true size, the ones nearest to the viewer on top."""
    order = np.argsort(snapshot.z, kind="stable")
    size = 2 * MM * snapshot.radius[order]
    grains = EllipseCollection(size, size, np.zeros(len(size)), units="xy", transOffset=ax.transData, linewidths=0,
                               offsets=MM * np.column_stack((snapshot.x[order], snapshot.y[order])))
    grains.set_facecolor(LAYERS(snapshot.colour[order] % LAYERS.N))
    ax.add_collection(grains)


def draw_field(ax, run, shear_map, field, cmap, low, high):
    """A map, cut at the surface of the sand."""
    snapshot = shear_map.increment.after
    x, y = surface(snapshot, run.diameter, run.depth)
    ends = np.array([snapshot.x.min() - 0.5 * run.diameter, snapshot.x.max() + 0.5 * run.diameter])
    base = snapshot.y.min() - 0.5 * run.diameter
    outline = MM * np.column_stack((np.concatenate((ends[:1], x, ends[1:], ends[::-1])),
                                    np.concatenate((y[:1], y, y[-1:], [base, base]))))
    image = ax.imshow(field, origin="lower", extent=[MM * edge for edge in shear_map.grid.extent], cmap=cmap, vmin=low, vmax=high,
                      interpolation="bilinear", aspect="auto", zorder=1)
    sand = Polygon(outline, closed=True, facecolor="none", edgecolor="#444444", lw=0.7, zorder=2)
    ax.add_patch(sand)
    image.set_clip_path(sand)
    return image


def draw_bands(ax, shear_map, least):
    """The two bands of an increment where they stand out: white dashes in the sand, a leader above it to their figures."""
    (left, right), top = ax.get_xlim(), ax.get_ylim()[1]
    for side, band in shear_map.bands.items():
        if band is None or band.contrast < least:
            continue
        y, grid = shear_map.grid.y, shear_map.grid
        column = np.clip(((band.x_at(y) - grid.x0) / grid.h).astype(int), 0, grid.nx - 1)
        on_sand = shear_map.counted[np.arange(len(y)), column]
        if not on_sand.any():
            continue
        low, high = y[on_sand].min(), y[on_sand].max() + grid.h
        tip = max(high, top / MM - 0.5 * Frame.headroom * shear_map.thickness)
        # The line ends where it leaves the frame.
        above = np.linspace(high, tip, 50)
        framed = above[(MM * band.x_at(above) >= left) & (MM * band.x_at(above) <= right)]
        tip = framed[-1] if len(framed) else high
        ax.plot(MM * band.x_at(np.array([low, high])), MM * np.array([low, high]), "--", color="white", lw=0.9, zorder=3)
        ax.plot(MM * band.x_at(np.array([high, tip])), MM * np.array([high, tip]), color=BAND[side], lw=1.2, zorder=3)
        # Written away from the other band, unless the frame ends there.
        x = min(max(MM * band.x_at(tip), left), right)
        to_left = x - left > 0.2 * (right - left) if side == RIGHT else right - x < 0.2 * (right - left)
        ax.annotate(f"{'fore' if side == RIGHT else 'back'} thrust, {band.dip:.0f}°, {band.contrast:.1f} × background", (x, MM * tip),
                    xytext=(-4 if to_left else 4, 0), textcoords="offset points", ha="right" if to_left else "left",
                    va="center", color=BAND[side], fontsize=8, zorder=4)


def evenly(items, most):
    """At most so many of the items, evenly spaced, the first and the last among them."""
    if len(items) <= most:
        return list(items)
    return [items[index] for index in np.unique(np.linspace(0, len(items) - 1, most).round().astype(int))]


def section(run, path, most=6):
    frame = Frame(run)
    snapshots = evenly(run.snapshots, most)
    figure, axes = frame.figure(len(snapshots))
    for ax, snapshot in zip(axes, snapshots):
        draw_walls(ax, run, snapshot.time)
        draw_grains(ax, snapshot)
        ax.set_title(f"{MM * run.shortening(snapshot.time):.1f} mm of shortening")
    figure.savefig(path)
    plt.close(figure)


def shear(run, maps, path, field, most=10):
    """One panel an increment: `field` is "shear" or "spin"."""
    frame = Frame(run, bar=0.85)
    shown = evenly(maps, most)
    inside = np.concatenate([m.shear[m.counted] for m in shown])
    high = float(np.percentile(inside[np.isfinite(inside)], 99.5)) if inside.size else 1.0
    figure, axes = frame.figure(len(shown))
    for ax, shear_map in zip(axes, shown):
        increment = shear_map.increment
        draw_walls(ax, run, increment.after.time)
        if field == "shear":
            image = draw_field(ax, run, shear_map, shear_map.shear, SHEAR, 0.0, high)
        else:
            image = draw_field(ax, run, shear_map, shear_map.spin, SPIN, -high, high)
        draw_bands(ax, shear_map, least=2.0)
        before, after = (MM * run.shortening(snapshot.time) for snapshot in (increment.before, increment.after))
        ax.set_title(f"{before:.1f} to {after:.1f} mm of shortening")
    frame.colour_bar(figure, axes, image, "shear strain increment √J₂" if field == "shear" else
                     "rotation (rad): dips left < 0 < dips right")
    figure.savefig(path)
    plt.close(figure)


def faults(run, shear_map, path):
    """The increment in which a pair of faults is clearest: the layers, and the strain that went through them."""
    frame = Frame(run, bar=0.85)
    figure, (layers, strain) = frame.figure(2)
    increment = shear_map.increment
    before, after = (MM * run.shortening(snapshot.time) for snapshot in (increment.before, increment.after))
    draw_walls(layers, run, increment.after.time)
    draw_grains(layers, increment.after)
    layers.set_title(f"Layers after {after:.1f} mm of shortening")
    draw_walls(strain, run, increment.after.time)
    high = float(np.nanpercentile(shear_map.shear[shear_map.counted], 99.7))
    image = draw_field(strain, run, shear_map, shear_map.shear, SHEAR, 0.0, high)
    draw_bands(strain, shear_map, least=1.5)
    strain.set_title(f"Shear strain from {before:.1f} to {after:.1f} mm")
    frame.colour_bar(figure, [strain], image, "shear strain √J₂")
    figure.savefig(path)
    plt.close(figure)


def forces(curves, marked, path):
    """Force on each wall over the displacement of the front wall. curves: name -> (distance, raw, even, smoothed)."""
    figure, axes = plt.subplots(len(curves), 1, figsize=(9.0, 0.9 + 2.3 * len(curves)), sharex=True, squeeze=False)
    for ax, (name, (distance, raw, even, mean)) in zip(axes[:, 0], curves.items()):
        ax.plot(MM * distance, raw, color="#b9c6d6", lw=0.5)
        ax.plot(MM * even, mean, color="#1f3f6e", lw=1.4)
        ax.set(ylabel="force (N)", title=name)
        ax.margins(x=0.01)
        # A jolt at the start must not flatten the curve that matters.
        low, high = min(0.0, float(mean.min())), max(0.0, float(mean.max()))
        ax.set_ylim(low - 0.08 * (high - low), high + 0.22 * (high - low) or 1.0)
        for drop in marked.get(name, []):
            ax.axvspan(MM * drop["from"], MM * drop["to"], color="#e9a13b", alpha=0.22, lw=0)
            ax.plot(MM * drop["from"], drop["force_before"], "o", color="#b3560d", ms=4)
            ax.annotate(f"−{100 * drop['share']:.0f} %", (MM * drop["from"], drop["force_before"]), xytext=(0, 6),
                        textcoords="offset points", ha="center", fontsize=8, color="#b3560d")
        for side in ("top", "right"):
            ax.spines[side].set_visible(False)
    axes[-1, 0].set_xlabel("displacement of the front wall (mm)")
    figure.tight_layout()
    figure.savefig(path)
    plt.close(figure)
