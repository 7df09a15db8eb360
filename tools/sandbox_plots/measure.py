"""What is read off a run beside the bands: the surface of the bed, and drops of the wall force."""
import numpy as np


def surface(snapshot, diameter, depth):
    """Height of the surface over x: (x, y), one bin every two diameters, NaN where there is no sand.

    In each bin it is the mean height of as many of its highest grains as half fill a layer there, so that neither one
    stray grain nor the thickness of the bed matters; then a running median of five bins.
    """
    width = 2.0 * diameter
    left = snapshot.x.min()
    bins = ((snapshot.x - left) / width).astype(int)
    count = bins.max() + 1
    order = np.lexsort((-snapshot.y, bins))
    sorted_bins = bins[order]
    rank = np.arange(len(order)) - np.searchsorted(sorted_bins, np.arange(count))[sorted_bins]
    highest = order[rank < max(2, int(0.5 * width * depth / diameter ** 2))]
    grains = np.bincount(bins[highest], minlength=count)
    with np.errstate(invalid="ignore"):
        height = np.bincount(bins[highest], (snapshot.y + snapshot.radius)[highest], count) / grains
    padded = np.pad(height, 2, mode="edge")
    height = np.median(np.lib.stride_tricks.sliding_window_view(padded, 5), axis=1)
    return left + (np.arange(count) + 0.5) * width, height


def initial_height(snapshot, diameter, depth):
    return float(np.nanmedian(surface(snapshot, diameter, depth)[1]))


def smoothed_curve(distance, force, window):
    """Force over an even grid of distance, averaged over `window` (a Hann window): (distance, force)."""
    rising = np.concatenate(([True], np.diff(np.maximum.accumulate(distance)) > 0))
    distance, force = distance[rising], force[rising]
    if len(distance) < 8 or distance[-1] - distance[0] < 4 * window:
        return distance, force
    even = np.linspace(distance[0], distance[-1], max(64, int(10 * (distance[-1] - distance[0]) / window)))
    # Means, not samples, go onto the even grid: the force is sampled far more often than that.
    total = np.concatenate(([0.0], np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(distance))))
    edges = np.concatenate(([even[0]], 0.5 * (even[1:] + even[:-1]), [even[-1]]))
    mean = np.diff(np.interp(edges, distance, total)) / np.diff(edges)
    half = max(1, int(round(window / (even[1] - even[0]))))
    kernel = np.hanning(2 * half + 1)
    weight = np.convolve(np.ones_like(mean), kernel, "same")
    return even, np.convolve(mean, kernel, "same") / weight


def drops(distance, force, least=0.1, floor=0.25):
    """Falls of the force, biggest share first: dicts of from/to distance and force, and the share lost.

    A fall runs from a maximum to the lowest point before the force has recovered a third of the loss (and more than
    a third of `least`, so that a wiggle does not cut a fall in two). Falls below `least`, or from a peak below the
    share `floor` of the greatest force, are left out.
    """
    found = []
    peak = low = 0
    for k in range(1, len(force) + 1):
        loss = force[peak] - force[low]
        over = k == len(force) or force[k] > force[peak] or force[k] - force[low] > max(loss, least * force[peak]) / 3
        if over:
            if force[peak] > floor * np.max(force) and loss >= least * force[peak]:
                # Where nearly all is lost: the very lowest point may lie far along a flat stretch.
                end = peak + int(np.argmax(force[peak:low + 1] <= force[low] + 0.05 * loss))
                found.append({"from": float(distance[peak]), "to": float(distance[end]),
                              "force_before": float(force[peak]), "force_after": float(force[low]),
                              "share": float(loss / force[peak])})
            peak = low = min(k, len(force) - 1)
        elif force[k] < force[low]:
            low = k
    return sorted(found, key=lambda drop: -drop["share"])
