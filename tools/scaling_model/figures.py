"""Efficiency over ranks, one curve a series."""
import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot


def efficiencies(parts, path):
    """@param parts {label: [Series]}"""
    figure, axes = pyplot.subplots(figsize=(7.5, 4.5), constrained_layout=True)
    styles = ("-", "--", ":", "-.")
    for index, (label, series) in enumerate(parts.items()):
        for number, s in enumerate(series):
            axes.plot([p.ranks for p in s.points], [p.efficiency for p in s.points], f"C{index}" + styles[number % 4], marker=".",
                      label=f"{label}, {s.name}")
    axes.plot([512, 1936], [1.0, 0.887], "k^", label="paper: Earth Simulator, 512 to 1936 nodes", markerfacecolor="none")
    axes.plot([1024, 16384], [1.0, 0.960], "ks", label="paper: K computer, 1024 to 16,384 nodes", markerfacecolor="none")
    axes.set(xscale="log", xlabel="ranks", ylabel="efficiency, relative to the first of a series", ylim=(0.5, 1.05))
    axes.set_xscale("log", base=2)
    axes.grid(alpha=0.3)
    axes.legend(fontsize="x-small", loc="lower left")
    figure.savefig(path, dpi=120)
    pyplot.close(figure)
