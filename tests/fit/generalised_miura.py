"""Makes generalised Miuras: sheets of quadrilaterals, no two of which need be equal, that fold flat with one degree of freedom.

Vertex (i, j), i = 1 ... rows - 1 and j = 1 ... columns - 1, has creases to the east, north, west and south, at directions phi,
phi + alpha, phi + alpha + beta and phi + beta + pi. These sectors, alpha, beta, pi - alpha and pi - beta, fulfil Kawasaki's
condition. With t = tan(fold angle / 2), t of north and south are equal, those of east and west opposite, and

    t_east / t_north = p = sin((alpha - beta) / 2) / sin((alpha + beta) / 2), or tan(beta / 2) = (1 - p) / (1 + p) tan(alpha / 2).

The sheet folds if the ratios agree round each panel, which is Tachi's condition (T. Tachi, "Generalization of rigid-foldable
quadrilateral-mesh origami", 2009): p(i, j) = a(i) c(j). The angles of each panel sum to 2 pi:

    alpha(i + 1, j + 1) = alpha(i, j) + beta(i, j + 1) - beta(i + 1, j).

So the sectors of the first row and of the first column determine all others, and with the lengths along these the vertices
inside. Creases that end on the border have lengths of their own, and corners complete parallelograms.

Parameters may be complex and may have further dimensions before the last: derivatives by a complex step are exact to rounding.
"""

from __future__ import annotations

import numpy as np


class GeneralisedMiura:
    """Sheets of ``rows`` x ``columns`` panels, both at least 3."""

    def __init__(self, rows: int, columns: int) -> None:
        self.rows, self.columns = rows, columns
        m, n = rows - 1, columns - 1
        #: Number of parameters: sectors of the first row and column, lengths along them, lengths to the border.
        self.sizes = {
            "row_alpha": n, "row_beta": n, "column_alpha": m - 1, "column_beta": m - 1, "row_lengths": n - 1,
            "column_lengths": m - 1, "west": m, "east": m, "south": n, "north": n,
        }  # fmt: skip
        self.count = sum(self.sizes.values())

    def regular(self, alpha: float = np.pi / 3, length: float = 1.0) -> np.ndarray:
        """Return the parameters of a Miura of equal parallelograms: sector angle (radians) and length of all sides."""
        m, n = self.rows - 1, self.columns - 1
        obtuse = np.where(np.arange(m) % 2 == 0, np.pi - alpha, alpha)
        sectors = [np.full(n, obtuse[0]), np.full(n, np.pi - obtuse[0]), obtuse[1:], np.pi - obtuse[1:]]
        return np.concatenate([*sectors, np.full(self.count - sum(map(len, sectors)), length)])

    def random(self, random: np.random.Generator, spread: float) -> np.ndarray:
        """Return the parameters of a sheet whose sectors (radians) and lengths differ by up to ``spread`` from a regular one."""
        return self.regular() + random.uniform(-spread, spread, self.count)

    def _parts(self, parameters: np.ndarray) -> dict[str, np.ndarray]:
        ends = np.cumsum(list(self.sizes.values()))[:-1]
        return dict(zip(self.sizes, np.split(np.moveaxis(np.asarray(parameters), -1, 0), ends)))

    def vertices(self, parameters: np.ndarray) -> np.ndarray:
        """Return the vertices of the flat sheet, (..., V, 2), row by row, for parameters (..., P)."""
        part, (m, n) = self._parts(parameters), (self.rows - 1, self.columns - 1)
        shape = (m, n, *part["west"].shape[1:])
        alpha, beta, phi = (np.zeros(shape, dtype=part["west"].dtype) for _ in range(3))
        at = np.zeros((self.rows + 1, self.columns + 1, 2, *shape[2:]), dtype=alpha.dtype)
        ratio = np.zeros_like(alpha)

        def set_ratio(i: int, j: int) -> None:
            ratio[i, j] = np.sin((alpha[i, j] - beta[i, j]) / 2) / np.sin((alpha[i, j] + beta[i, j]) / 2)

        def along(direction: np.ndarray) -> np.ndarray:
            return np.stack([np.cos(direction), np.sin(direction)])

        alpha[0], beta[0] = part["row_alpha"], part["row_beta"]
        alpha[1:, 0], beta[1:, 0] = part["column_alpha"], part["column_beta"]
        for i in range(m):
            for j in range(n):
                if i and j:
                    alpha[i, j] = alpha[i - 1, j - 1] + beta[i - 1, j] - beta[i, j - 1]
                    p = ratio[i, 0] * ratio[0, j] / ratio[0, 0]
                    beta[i, j] = 2 * np.arctan((1 - p) / (1 + p) * np.tan(alpha[i, j] / 2))
                set_ratio(i, j)
                if j:
                    phi[i, j] = phi[i, j - 1] + np.pi - alpha[i, j] - beta[i, j]
                elif i:
                    phi[i, 0] = phi[i - 1, 0] + alpha[i - 1, 0] - beta[i, 0]
        east, north = along(phi), along(phi + alpha)
        west, south = along(phi + alpha + beta), -along(phi + beta)
        inner = at[1:-1, 1:-1]
        for i in range(m):
            for j in range(n):
                if i and j:
                    # The crease to the east of the vertex before meets that to the north of the vertex below.
                    a, b = inner[i, j - 1], inner[i - 1, j]
                    u, v, gap = east[:, i, j - 1], north[:, i - 1, j], b - a
                    inner[i, j] = a + u * (gap[0] * v[1] - gap[1] * v[0]) / (u[0] * v[1] - u[1] * v[0])
                elif j:
                    inner[0, j] = inner[0, j - 1] + east[:, 0, j - 1] * part["row_lengths"][j - 1]
                elif i:
                    inner[i, 0] = inner[i - 1, 0] + north[:, i - 1, 0] * part["column_lengths"][i - 1]
        for i in range(m):
            at[i + 1, 0] = inner[i, 0] + west[:, i, 0] * part["west"][i]
            at[i + 1, -1] = inner[i, -1] + east[:, i, -1] * part["east"][i]
        for j in range(n):
            at[0, j + 1] = inner[0, j] + south[:, 0, j] * part["south"][j]
            at[-1, j + 1] = inner[-1, j] + north[:, -1, j] * part["north"][j]
        for i, k in ((0, 1), (-1, -2)):
            for j, l in ((0, 1), (-1, -2)):
                at[i, j] = at[i, l] + at[k, j] - at[k, l]
        return np.moveaxis(at.reshape(-1, 2, *shape[2:]), (0, 1), (-2, -1))

    def derivatives(self, parameters: np.ndarray) -> np.ndarray:
        """Return the derivatives of the vertices by the parameters: (P, V, 2)."""
        step = 1e-30
        return self.vertices(np.asarray(parameters) + 1j * step * np.eye(self.count)).imag / step

    def edges(self) -> np.ndarray:
        """Return the vertices of the edges: (E, 2); first those along rows, then those along columns."""
        number = np.arange((self.rows + 1) * (self.columns + 1)).reshape(self.rows + 1, self.columns + 1)
        along_rows = np.stack([number[:, :-1], number[:, 1:]], axis=-1)
        along_columns = np.stack([number[:-1], number[1:]], axis=-1)
        return np.concatenate([along_rows.reshape(-1, 2), along_columns.reshape(-1, 2)])

    def faces(self) -> list[list[int]]:
        """Return the vertices of each panel, counter-clockwise."""
        wide = self.columns + 1
        corners = [i * wide + j for i in range(self.rows) for j in range(self.columns)]
        return [[at, at + 1, at + wide + 1, at + wide] for at in corners]

    def angles(self, parameters: np.ndarray, driver: int, angle: float) -> np.ndarray:
        """Return the fold angles at which the sheet is closed, (E,), radians, nan on the border, and edge ``driver`` has this
        angle."""
        part, n = self._parts(parameters), self.columns - 1

        def ratios(alpha: np.ndarray, beta: np.ndarray) -> np.ndarray:
            return np.sin((alpha - beta) / 2) / np.sin((alpha + beta) / 2)

        first = ratios(part["row_alpha"], part["row_beta"])
        rows = np.append(first[0], ratios(part["column_alpha"], part["column_beta"]))
        # Half tangents over that of the first column. Beyond each vertex those along rows change their sign, and so do columns.
        along_rows = np.full((self.rows + 1, self.columns), np.nan)
        along_rows[1:-1] = -rows[:, None] * (-1.0) ** np.arange(self.columns)
        along_columns = np.full((self.rows, self.columns + 1), np.nan)
        along_columns[:, 1:-1] = first[0] / first * (-1.0) ** np.arange(n)
        tangents = np.concatenate([along_rows.ravel(), along_columns.ravel()])
        return 2 * np.arctan(tangents * np.tan(angle / 2) / tangents[driver])
