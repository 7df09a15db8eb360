"""Shear bands in the map of one strain increment: where the two conjugate families run, how steep and how strong.

The shear is split by the sense of rotation into two maps, one for bands that dip to the right (towards +x) and one for
those that dip to the left. In each, straight lines of every dip and place are laid through the sand, from above the
decollement at the floor to the surface; the line with the greatest mean is the band. (A Radon transform, in other
words; it does not mind a band being patchy.) In the experiment the back stop is at high x: a band that dips to the
right, towards it, is a fore thrust, one that dips to the left a back thrust. The local direction of the bands is had a
second way, from the structure tensor.
"""
import numpy as np

from .strain import smooth

RIGHT, LEFT = "right", "left"


class Band:
    """A straight band: crosses height y_middle at x_middle, dips by `dip` degrees to `side`."""

    def __init__(self, side, dip, x_middle, y_middle, mean, background):
        self.side, self.dip, self.x_middle, self.y_middle = side, dip, x_middle, y_middle
        self.mean, self.background = mean, background
        self.dip_local = float("nan")

    @property
    def contrast(self):
        return self.mean / self.background if self.background > 0 else float("inf")

    def x_at(self, y):
        slope = 1.0 / np.tan(np.radians(self.dip))
        return self.x_middle + (self.y_middle - y) * (slope if self.side == RIGHT else -slope)

    def as_json(self):
        return {
            "dips_to": self.side,
            "dip_deg": round(self.dip, 1),
            "dip_from_structure_tensor_deg": round(self.dip_local, 1) if np.isfinite(self.dip_local) else None,
            "x_at_mid_depth_mm": round(1e3 * self.x_middle, 2),
            "mean_shear": round(self.mean, 5),
            "background_median_shear": round(self.background, 5),
            "ratio_to_background": round(self.contrast, 2),
        }


class ShearMap:
    """Shear and spin of an increment on a grid, and the bands in them."""

    dips = np.arange(18.0, 71.0)
    floor_share = 0.15      # of the thickness: the sheared layer on the moving floor belongs to no band
    wall_diameters = 5.0    # likewise the sand dragged along by the end walls
    # A line counts where at least this share of the thickness at its place is sand: not the corners.
    least_share = 0.75

    def __init__(self, grid, increment, diameter):
        self.grid, self.increment, self.diameter = grid, increment, diameter
        cells = 1.2 * diameter / grid.h
        # Values reach a little beyond the sand, so that pictures can be cut at its very surface; `inside` is for measuring.
        self.shear = grid.mean(increment.shear, cells)
        self.spin = grid.mean(increment.spin, cells)
        known = grid.inside & np.isfinite(self.shear) & (self.shear > 0)
        sense = np.clip(np.divide(self.spin, self.shear, out=np.zeros_like(self.spin), where=known), -1, 1)
        self.family = {RIGHT: np.nan_to_num(self.shear * np.maximum(sense, 0)),
                       LEFT: np.nan_to_num(self.shear * np.maximum(-sense, 0))}

        rows = np.flatnonzero(grid.inside.any(axis=1))
        bottom = grid.y[rows[0]]
        columns = grid.inside.any(axis=0)
        top = np.where(columns, grid.y[grid.inside.shape[0] - 1 - np.argmax(grid.inside[::-1], axis=0)], np.nan)
        self.thickness = float(np.nanmedian(top) - bottom)
        ends = grid.x[np.flatnonzero(columns)[[0, -1]]] + np.array([1, -1]) * self.wall_diameters * diameter
        self.counted = known & (grid.y[:, None] > bottom + self.floor_share * self.thickness)
        self.counted &= (grid.x > ends[0]) & (grid.x < ends[1])
        self.background = float(np.nanmedian(self.shear[self.counted])) if self.counted.any() else float("nan")
        self.bands = {side: self._strongest(side) for side in (RIGHT, LEFT)}

    def _strongest(self, side):
        grid = self.grid
        rows = np.flatnonzero(self.counted.any(axis=1))
        if len(rows) < 4:
            return None
        middle = 0.5 * (grid.y[rows[0]] + grid.y[rows[-1]])
        columns_deep = np.maximum(1, self.counted.sum(axis=0))
        sign = 1.0 if side == RIGHT else -1.0
        score = np.zeros((len(self.dips), grid.nx))
        for index, dip in enumerate(self.dips):
            total, length, deep = np.zeros(grid.nx), np.zeros(grid.nx), np.zeros(grid.nx)
            for row in rows:
                x = grid.x + sign * (middle - grid.y[row]) / np.tan(np.radians(dip))
                here = np.interp(x, grid.x, self.counted[row].astype(float), 0, 0)
                total += here * np.interp(x, grid.x, self.family[side][row], 0, 0)
                length += here
                deep += here * np.interp(x, grid.x, columns_deep, 0, 0)
            whole = length >= self.least_share * np.divide(deep, length, out=np.ones_like(deep), where=length > 0)
            score[index] = np.where(whole & (length > 3), total / np.maximum(length, 1), 0)
        dip_index, column = np.unravel_index(np.argmax(score), score.shape)
        if score[dip_index, column] <= 0:
            return None
        dip = self.dips[dip_index] + _parabola(score[:, column], dip_index)
        place = grid.x[column] + _parabola(score[dip_index], column) * grid.h
        band = Band(side, float(dip), float(place), float(middle), 0.0, self.background)
        strip = self._strip(band)
        if not strip.any():
            return None
        band.mean = float(np.nanmean(self.shear[strip]))
        band.dip_local = self._local_dip(side, self._strip(band, 3.0))
        return band

    def _strip(self, band, diameters=1.5):
        """Cells within so many diameters of the band's middle line."""
        across = (self.grid.x - band.x_at(self.grid.y)[:, None]) * np.sin(np.radians(band.dip))
        return self.counted & (np.abs(across) < diameters * self.diameter)

    def _local_dip(self, side, strip):
        """Dip from the structure tensor: the direction along which the shear of this family changes least."""
        cells = self.diameter / self.grid.h
        along_y, along_x = np.gradient(smooth(self.family[side], cells))
        # The edge of the sand and the layer on the floor are gradients too, of no band.
        rows = np.flatnonzero(self.counted.any(axis=1))
        deep_enough = self.grid.y > self.grid.y[rows[0]] + self.floor_share * self.thickness
        strip = strip & (smooth(self.grid.inside.astype(float), cells) > 0.99) & deep_enough[:, None]
        xx, xy, yy = (np.sum((a * b)[strip]) for a, b in ((along_x, along_x), (along_x, along_y), (along_y, along_y)))
        across = 0.5 * np.arctan2(2 * xy, xx - yy)  # direction of the greatest change
        direction = np.degrees(across) + 90.0
        dip = (-direction if side == RIGHT else direction) % 180.0
        return float(dip) if dip < 90.0 else float("nan")

    @property
    def clarity(self):
        """How clearly a pair of opposite bands stands out: the weaker one's ratio to the background."""
        if any(band is None for band in self.bands.values()) or not self.background > 0:
            return 0.0
        return min(band.contrast for band in self.bands.values())


def _parabola(values, index):
    """Offset of the top of the parabola through a maximum and its two neighbours, in steps of the index."""
    if index == 0 or index == len(values) - 1:
        return 0.0
    a, b, c = values[index - 1:index + 2]
    curvature = a - 2 * b + c
    return float(np.clip(0.5 * (a - c) / curvature, -0.5, 0.5)) if curvature < 0 else 0.0
