"""Closed meshes of quadrilaterals."""

import numpy as np

Corners = tuple[int, int, int, int]


def edge(a: int, b: int) -> tuple[int, int]:
    return min(a, b), max(a, b)


class QuadMesh:
    """Quadrilaterals, counter-clockwise seen from outside. Closed after every step."""

    def __init__(self) -> None:
        self.vertices: list[np.ndarray] = []
        self.quads: dict[int, Corners] = {}
        self.tips: dict[int, np.ndarray] = {}  # of quads that are round ends
        self.next_quad = 0
        self.edges: set[tuple[int, int]] = set()  # (lower, higher); none ever vanishes

    def add_quad(self, corners: Corners) -> int:
        self.quads[self.next_quad] = corners
        self.next_quad += 1
        self.edges |= {edge(a, b) for a, b in zip(corners, corners[1:] + corners[:1])}
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
        where they touch or an edge joins them already."""
        a, b = self.quads[one], self.quads[other]
        if set(a) & set(b) or any(edge(p, q) in self.edges for p in a for q in b):
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

    def cuts(self, corners: Corners, taken: set[tuple[int, int]]) -> list[Corners]:
        """The quad's corners from the end of a diagonal that is not taken, the shorter one first;
        none where both are."""
        a, b, c, d = corners
        ways = sorted(
            (corners, (b, c, d, a)),
            key=lambda way: float(np.linalg.norm(self.vertices[way[0]] - self.vertices[way[2]])),
        )
        return [way for way in ways if edge(way[0], way[2]) not in taken]

    def triangles(self) -> tuple[np.ndarray, np.ndarray]:
        """Vertices and triangles. Each quad is cut along a diagonal, or round its tip, or its middle
        where others are cut along both."""
        vertices, taken = list(self.vertices), set(self.edges)
        triangles: list[tuple[int, int, int]] = []
        for quad, corners in self.quads.items():
            ways = [] if quad in self.tips else self.cuts(corners, taken)
            if ways:
                a, b, c, d = ways[0]
                taken.add(edge(a, c))
                triangles += [(a, b, c), (a, c, d)]
                continue
            centre = len(vertices)
            vertices.append(self.tips[quad] if quad in self.tips else self.middle(quad))
            triangles += [(p, q, centre) for p, q in zip(corners, corners[1:] + corners[:1])]
        used, numbers = np.unique(np.array(triangles), return_inverse=True)
        return np.array(vertices)[used], numbers.reshape(-1, 3)
