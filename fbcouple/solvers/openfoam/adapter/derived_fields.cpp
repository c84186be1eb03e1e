// Vector fields that only some forces on the particles ask for: nothing of them is kept or calculated otherwise.

#include <cstring>
#include <stdexcept>

#include "adapter.hpp"
#include "turbulenceModel.H"
#include "wallFvPatch.H"

using namespace Foam;

// Along a wall the velocity normal to it is zero everywhere, so its tangential derivatives there are too; the value of
// the cell in their place would be a false shear stress on it.
tmp<fvVectorMatrix> viscousForce(const volScalarField& nu, const volVectorField& U)
{
    volTensorField gradU(fvc::grad(U));
    forAll(U.mesh().boundary(), patchi)
    {
        if (!isA<wallFvPatch>(U.mesh().boundary()[patchi])) continue;
        const vectorField n(U.mesh().boundary()[patchi].nf());
        tensorField& atWall = gradU.boundaryFieldRef()[patchi];
        const vectorField normal(atWall & n);
        atWall -= (normal - n*(n & normal))*n;
    }
    return fvm::laplacian(nu, U) + fvc::div(nu*dev2(gradU.T()), "div(viscousStress)");
}

namespace
{

tmp<volVectorField> derive(const char* name)
{
    const fvMesh& mesh = gasMesh();
    const volVectorField& U = mesh.lookupObject<volVectorField>("U");
    if (!std::strcmp(name, "curl")) return fvc::curl(U);
    if (!std::strcmp(name, "convection")) return U & fvc::grad(U);
    if (std::strcmp(name, "viscous")) throw std::runtime_error(std::string("no derived field ") + name);
    const volScalarField nu(mesh.lookupObject<turbulenceModel>(turbulenceModel::propertiesName).nuEff());
    return viscousForce(nu, U) & U;
}

}

// Rows (cells, 3): "curl" of the velocity [1/s], "convection" u.grad(u) [m/s2], "viscous" div(tau)/rho [m/s2].
extern "C" int gas_derive(const char* name, double* values)
{
    return guarded([&]
    {
        const tmp<volVectorField> field(derive(name));
        forAll(field(), i)
        {
            for (direction d = 0; d < 3; ++d) values[3*i + d] = field()[i][d];
        }
    });
}
