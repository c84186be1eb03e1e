// The mesh of this process for those who have to find particles in it: asked for once, and only on meshes of polyhedra.

#include <cstdint>

#include "adapter.hpp"
#include "labelIOList.H"

using namespace Foam;

namespace
{

// Numbers in the whole mesh of what this process has a part of.
void number(const word& name, label count, int64_t* values)
{
    const fvMesh& mesh = gasMesh();
    if (!Pstream::parRun())
    {
        for (label i = 0; i < count; ++i) values[i] = i;
        return;
    }
    const labelIOList numbers
    (
        IOobject(name, mesh.facesInstance(), mesh.meshSubDir, mesh, IOobject::MUST_READ, IOobject::NO_WRITE, false)
    );
    forAll(numbers, i) values[i] = numbers[i];
}

}

// Points, faces, inner faces, and points of all faces together.
extern "C" int gas_mesh_sizes(int64_t* sizes)
{
    return guarded([&]
    {
        const fvMesh& mesh = gasMesh();
        sizes[0] = mesh.nPoints();
        sizes[1] = mesh.nFaces();
        sizes[2] = mesh.nInternalFaces();
        sizes[3] = 0;
        forAll(mesh.faces(), f) sizes[3] += mesh.faces()[f].size();
    });
}

// Points (n, 3) [m]; the lengths of the faces, then their points; owner of each face, neighbour of each inner one;
// numbers of cells and points in the whole mesh.
extern "C" int gas_mesh
(
    double* points, int64_t* lengths, int64_t* corners, int64_t* owner, int64_t* neighbour, int64_t* cells, int64_t* ids
)
{
    return guarded([&]
    {
        const fvMesh& mesh = gasMesh();
        forAll(mesh.points(), i)
        {
            for (direction d = 0; d < 3; ++d) points[3*i + d] = mesh.points()[i][d];
        }
        label place = 0;
        forAll(mesh.faces(), f)
        {
            const face& around = mesh.faces()[f];
            lengths[f] = around.size();
            owner[f] = mesh.faceOwner()[f];
            forAll(around, k) corners[place++] = around[k];
        }
        forAll(mesh.faceNeighbour(), f) neighbour[f] = mesh.faceNeighbour()[f];
        number("cellProcAddressing", mesh.nCells(), cells);
        number("pointProcAddressing", mesh.nPoints(), ids);
    });
}
