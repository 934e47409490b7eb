"""Closed meshes of quadrilaterals."""

import numpy as np


class QuadMesh:
    """Quadrilaterals, counter-clockwise seen from outside. Closed after every step."""

    def __init__(self) -> None:
        self.vertices: list[np.ndarray] = []
        self.quads: dict[int, tuple[int, int, int, int]] = {}
        self.tips: dict[int, np.ndarray] = {}  # of quads that are round ends
        self.next_quad = 0

    def add_quad(self, corners: tuple[int, int, int, int]) -> int:
        self.quads[self.next_quad] = corners
        self.next_quad += 1
        return self.next_quad - 1

    def middle(self, quad: int) -> np.ndarray:
        return np.mean([self.vertices[v] for v in self.quads[quad]], axis=0)

    def normal(self, quad: int) -> np.ndarray:
        a, b, c, d = (self.vertices[v] for v in self.quads[quad])
        normal = np.cross(c - a, d - b)
        return normal / max(np.linalg.norm(normal), 1e-12)

    def size(self, quad: int) -> float:
        """The length of a diagonal."""
        a, _, c, _ = (self.vertices[v] for v in self.quads[quad])
        return max(float(np.linalg.norm(c - a)), 1e-12)

    def bridge(self, one: int, other: int) -> bool:
        """Takes two quads away and joins their borders by four new ones, the shortest way; false
        where they touch."""
        a, b = self.quads[one], self.quads[other]
        if set(a) & set(b):
            return False

        def partner(shift: int, k: int) -> int:
            return b[(shift - k) % 4]

        def span(shift: int) -> float:
            return sum(
                float(np.linalg.norm(self.vertices[a[k]] - self.vertices[partner(shift, k)]))
                for k in range(4)
            )

        shift = min(range(4), key=span)
        del self.quads[one], self.quads[other]
        for k in range(4):
            self.add_quad((a[k], a[(k + 1) % 4], partner(shift, k + 1), partner(shift, k)))
        return True

    @staticmethod
    def first_is_shorter(corners: np.ndarray) -> bool:
        a, b, c, d = corners
        return bool(np.linalg.norm(a - c) <= np.linalg.norm(b - d))

    def triangles(self) -> tuple[np.ndarray, np.ndarray]:
        """Vertices and triangles, each quad cut along its shorter diagonal, or round its tip."""
        vertices = np.array(self.vertices + list(self.tips.values()))
        tips = {quad: len(self.vertices) + i for i, quad in enumerate(self.tips)}
        triangles = []
        for quad, (a, b, c, d) in self.quads.items():
            if quad in tips:
                tip = tips[quad]
                triangles += [(a, b, tip), (b, c, tip), (c, d, tip), (d, a, tip)]
            elif self.first_is_shorter(vertices[[a, b, c, d]]):
                triangles += [(a, b, c), (a, c, d)]
            else:
                triangles += [(a, b, d), (b, c, d)]
        used, numbers = np.unique(np.array(triangles), return_inverse=True)
        return vertices[used], numbers.reshape(-1, 3)
