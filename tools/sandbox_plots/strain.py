"""Strain of a granular bed between two snapshots, seen in the x-y plane.

For every grain the gradient of the displacement increment (u, v) is fitted by least squares to the grains within a
radius R of it, weighted by 1 - (r/R)^2: u(x, y) = a + u_x (x - x_i) + u_y (y - y_i). The fit has a constant of its own, so that
the jitter of the grain in the middle does not enter, and uses positions half way between the snapshots, which makes
the strain of a rotating block vanish to second order. From the gradient

    e_ij   = (u_i,j + u_j,i) / 2                                   strain increment
    shear  = sqrt(J2),  J2 = e'_ij e'_ij / 2 = ((e_xx - e_yy)/2)^2 + e_xy^2,   e' = e - tr(e)/2 I   (two dimensions)
    spin   = (v,x - u,y) / 2                                       rotation, counter-clockwise positive

A band of simple shear g has shear = |spin| = |g|/2, whatever its direction; the sign of the spin tells two conjugate thrusts apart:
a thrust that dips to the right (towards +x) turns counter-clockwise, one that dips to the left clockwise.
"""
import numpy as np


def cell_pairs(x, y, radius):
    """All pairs (i, j) closer than `radius`, each once, by a cell list: yields blocks of index arrays."""
    nx = max(1, int(np.ptp(x) / radius) + 1)
    ny = max(1, int(np.ptp(y) / radius) + 1)
    column = ((x - x.min()) / radius).astype(np.int64)
    row = ((y - y.min()) / radius).astype(np.int64)
    cell = row * nx + column
    order = np.argsort(cell, kind="stable")
    start = np.searchsorted(cell[order], np.arange(nx * ny + 1))
    for step_x, step_y in ((0, 0), (1, 0), (-1, 1), (0, 1), (1, 1)):
        to_x, to_y = column + step_x, row + step_y
        inside = np.flatnonzero((to_x >= 0) & (to_x < nx) & (to_y < ny))
        target = to_y[inside] * nx + to_x[inside]
        count = start[target + 1] - start[target]
        i = np.repeat(inside, count)
        first_pair = np.cumsum(count) - count
        j = order[np.arange(len(i)) - np.repeat(first_pair - start[target], count)]
        close = (x[i] - x[j]) ** 2 + (y[i] - y[j]) ** 2 < radius * radius
        if step_x == step_y == 0:
            close &= i < j
        yield i[close], j[close]


def gradients(x, y, u, v, radius):
    """(u_x, u_y, v_x, v_y) at every grain; NaN where fewer than five neighbours or a flat cloud leave it open."""
    n = len(x)
    even = np.zeros((8, n))  # w, wxx, wxy, wyy, wxu, wyu, wxv, wyv (the same seen from i and from j)
    odd = np.zeros((4, n))   # wx, wy, wu, wv (of opposite sign)
    neighbours = np.zeros(n)
    even[0] = 1.0            # the grain itself, at distance zero
    for i, j in cell_pairs(x, y, radius):
        dx, dy, du, dv = x[j] - x[i], y[j] - y[i], u[j] - u[i], v[j] - v[i]
        w = 1.0 - (dx * dx + dy * dy) / (radius * radius)
        wx, wy = w * dx, w * dy
        for moment, value in enumerate((w, wx * dx, wx * dy, wy * dy, wx * du, wy * du, wx * dv, wy * dv)):
            even[moment] += np.bincount(i, value, n) + np.bincount(j, value, n)
        for moment, value in enumerate((wx, wy, w * du, w * dv)):
            odd[moment] += np.bincount(i, value, n) - np.bincount(j, value, n)
        neighbours += np.bincount(i, minlength=n) + np.bincount(j, minlength=n)

    w, wxx, wxy, wyy, wxu, wyu, wxv, wyv = even
    wx, wy, wu, wv = odd
    xx, xy, yy = wxx - wx * wx / w, wxy - wx * wy / w, wyy - wy * wy / w
    xu, yu, xv, yv = wxu - wx * wu / w, wyu - wy * wu / w, wxv - wx * wv / w, wyv - wy * wv / w
    determinant = xx * yy - xy * xy
    # A cloud on a line has a determinant of zero: no gradient across it.
    open_fit = (neighbours < 5) | (determinant < 1e-3 * (0.5 * (xx + yy)) ** 2)
    determinant = np.where(open_fit, np.nan, determinant)
    return ((yy * xu - xy * yu) / determinant, (xx * yu - xy * xu) / determinant,
            (yy * xv - xy * yv) / determinant, (xx * yv - xy * xv) / determinant)


class Increment:
    """Strain between two snapshots at the grains of both: x, y (at the later one), shear, spin, volume."""

    def __init__(self, before, after, radius):
        from .run import matched
        a, b = matched(before, after)
        u, v = after.ux[b] - before.ux[a], after.uy[b] - before.uy[a]
        self.x, self.y = after.x[b], after.y[b]
        ux, uy, vx, vy = gradients(self.x - 0.5 * u, self.y - 0.5 * v, u, v, radius)
        self.shear = np.hypot(0.5 * (ux - vy), 0.5 * (uy + vx))
        self.spin = 0.5 * (vx - uy)
        self.volume = ux + vy
        self.before, self.after = before, after


class Grid:
    """Square cells over the section. `inside` marks those that hold sand, judged over a circle of `grain` across."""

    def __init__(self, x, y, spacing, grain):
        self.h = spacing
        self.x0, self.y0 = x.min() - 2 * spacing, y.min() - 2 * spacing
        self.nx = int((x.max() - self.x0) / spacing) + 4
        self.ny = int((y.max() - self.y0) / spacing) + 4
        self.x = self.x0 + (np.arange(self.nx) + 0.5) * spacing
        self.y = self.y0 + (np.arange(self.ny) + 0.5) * spacing
        self.extent = (self.x0, self.x0 + self.nx * spacing, self.y0, self.y0 + self.ny * spacing)
        column = ((x - self.x0) / spacing).astype(int)
        row = ((y - self.y0) / spacing).astype(int)
        self.cell = row * self.nx + column
        self.count = np.bincount(self.cell, minlength=self.nx * self.ny).reshape(self.ny, self.nx)
        density = smooth(self.count.astype(float), 0.6 * grain / spacing)
        self.inside = density > 0.45 * np.median(density[density > 0.1 * density.max()])

    def mean(self, value, cells):
        """Grain values on the grid, smoothed by a Gaussian of `cells` cells; NaN where no grain is near."""
        known = np.isfinite(value)
        total = np.bincount(self.cell[known], value[known], self.nx * self.ny).reshape(self.ny, self.nx)
        count = np.bincount(self.cell[known], minlength=self.nx * self.ny).reshape(self.ny, self.nx)
        weight = smooth(count.astype(float), cells)
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.where(weight > 1e-3 * weight.max(), smooth(total, cells) / weight, np.nan)


def smooth(field, cells):
    """Convolution with a Gaussian of standard deviation `cells`, zero beyond the edges."""
    reach = max(1, int(np.ceil(3 * cells)))
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / cells) ** 2)
    kernel /= kernel.sum()
    for axis in range(field.ndim):
        field = np.apply_along_axis(np.convolve, axis, field, kernel, mode="full")
        field = np.take(field, np.arange(reach, field.shape[axis] - reach), axis=axis)
    return field
