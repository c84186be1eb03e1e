// What the adapter's C++ files share.

#ifndef fbcouple_adapter
#define fbcouple_adapter

#include <functional>

#include "fvCFD.H"

// The mesh of the open gas, with all its fields registered in it.
const Foam::fvMesh& gasMesh();

// Run an action of the C interface: 0, or 1 with the reason in gas_error().
int guarded(const std::function<void()>& action);

// div(nu (grad U + grad U^T - 2/3 div U)), its first part implicit.
Foam::tmp<Foam::fvVectorMatrix> viscousForce(const Foam::volScalarField& nu, const Foam::volVectorField& U);

#endif
