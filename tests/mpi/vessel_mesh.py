"""A vessel by gmsh, `python vessel_mesh.py FILE`: a square column about its own axis with a pipe into its side, whose
end is the patch spill, and a round hole in its floor, the patch drain; gas comes in by the rest of the floor.

It runs as a process of its own: gmsh brings libraries of its own into the process.
"""

import sys

import gmsh


def main(path):
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    shapes = gmsh.model.occ
    column = shapes.addBox(-0.006, -0.006, 0, 0.012, 0.012, 0.03)
    pipe = shapes.addCylinder(0, 0, 0.012, 0.014, 0, 0, 0.004)
    (body, *_), _ = shapes.fuse([(3, column)], [(3, pipe)])
    shapes.fragment([body], [(2, shapes.addDisk(0, 0, 0, 0.003, 0.003))])
    shapes.synchronize()
    groups = {"drain": [], "inlet": [], "outlet": [], "spill": []}
    for _, tag in gmsh.model.getEntities(2):
        x, _, z = shapes.getCenterOfMass(2, tag)
        if abs(z) < 1e-9:
            groups["drain" if shapes.getMass(2, tag) < 5e-5 else "inlet"].append(tag)
        elif abs(z - 0.03) < 1e-9:
            groups["outlet"].append(tag)
        elif abs(x - 0.014) < 1e-9:
            groups["spill"].append(tag)
    for name, tags in groups.items():
        assert len(tags) == 1, name
        gmsh.model.setPhysicalName(2, gmsh.model.addPhysicalGroup(2, tags), name)
    gmsh.model.setPhysicalName(3, gmsh.model.addPhysicalGroup(3, [body[1]]), "bed")
    gmsh.option.setNumber("Mesh.MeshSizeMax", 0.003)
    gmsh.model.mesh.generate(3)
    gmsh.write(path)
    gmsh.finalize()


if __name__ == "__main__":
    main(sys.argv[1])
