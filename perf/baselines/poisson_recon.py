"""poisson_recon.py POINTS.ply SURFACE.ply [--depth D]: a surface of points by pymeshlab.

Kazhdan, Hoppe: Screened Poisson surface reconstruction, 2013.
"""

import argparse

import pymeshlab


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("points")
    parser.add_argument("surface")
    parser.add_argument("--depth", type=int, default=9)
    arguments = parser.parse_args()
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(arguments.points)
    # Its threads wait busily: on a shared machine one is the quickest.
    meshes.generate_surface_reconstruction_screened_poisson(depth=arguments.depth, threads=1)
    meshes.save_current_mesh(arguments.surface, save_vertex_quality=False, save_vertex_normal=False)


if __name__ == "__main__":
    main()
