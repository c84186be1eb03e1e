// The turbulence models of the volume-averaged gas and their selection tables: OpenFOAM's own templates over the base
// beside this file, and `localizedDynamic`, written here.

#include "addToRunTimeSelectionTable.H"
#include "averaged_turbulence.hpp"
#include "bound.H"
#include "fvCFD.H"
#include "makeTurbulenceModel.H"
#include "volPointInterpolation.H"

#include "LESModel.H"
#include "RASModel.H"
#include "laminarModel.H"

#include "Smagorinsky.H"
#include "Stokes.H"
#include "dynamicLagrangian.H"
#include "kEqn.H"

// Both, as v1912 has the names of the types in the first and later versions in either.
makeTurbulenceModelTypes
(
    volScalarField,
    geometricOneField,
    incompressibleTurbulenceModel,
    averagedTurbulenceModel,
    singlePhaseTransportModel
);

makeBaseTurbulenceModel
(
    volScalarField,
    geometricOneField,
    incompressibleTurbulenceModel,
    averagedTurbulenceModel,
    singlePhaseTransportModel
);

makeTemplatedTurbulenceModel(singlePhaseTransportModelaveragedTurbulenceModel, laminar, Stokes);
makeTemplatedTurbulenceModel(singlePhaseTransportModelaveragedTurbulenceModel, LES, Smagorinsky);
makeTemplatedTurbulenceModel(singlePhaseTransportModelaveragedTurbulenceModel, LES, kEqn);
makeTemplatedTurbulenceModel(singlePhaseTransportModelaveragedTurbulenceModel, LES, dynamicLagrangian);

namespace Foam
{
namespace LESModels
{

// The trapezoidal mean over a box of two cells a side: to the corners of the cells and back, on a regular mesh the
// product of (1/4, 1/2, 1/4) along each axis. Boundary values stay what they are.
template<class Type>
tmp<GeometricField<Type, fvPatchField, volMesh>> testFilter(const GeometricField<Type, fvPatchField, volMesh>& field)
{
    typedef GeometricField<Type, fvPatchField, volMesh> fieldType;
    const fvMesh& mesh = field.mesh();
    const auto corners(volPointInterpolation::New(mesh).interpolate(field));
    tmp<fieldType> mean(fieldType::New("test(" + field.name() + ")", mesh, dimensioned<Type>(field.dimensions(), Zero)));
    const labelListList& points = mesh.cellPoints();
    forAll(points, celli)
    {
        Type sum(Zero);
        forAll(points[celli], i) sum += corners()[points[celli][i]];
        mean.ref().primitiveFieldRef()[celli] = sum/points[celli].size();
    }
    forAll(mesh.boundary(), patchi)
    {
        if (!mesh.boundary()[patchi].coupled()) mean.ref().boundaryFieldRef()[patchi] == field.boundaryField()[patchi];
    }
    mean.ref().correctBoundaryConditions();
    return mean;
}

template<class Type>
tmp<GeometricField<Type, fvPatchField, volMesh>> testFilter(const tmp<GeometricField<Type, fvPatchField, volMesh>>& f)
{
    return testFilter(f());
}

// nu_t = C Delta^2 |S|, the coefficient of each cell from the Germano identity between the mesh and the test filter of
// width 2 Delta (Germano et al. 1991), by least squares (Lilly 1992): C = <L:M>/<M:M> with
//   L = dev(test(u u) - test(u) test(u)),  M = 2 Delta^2 (test(|S| S) - 4 |Sf| Sf),  Sf of test(u), |S| = sqrt(S:S).
// <> is the test filter too: a local mean, as no direction is homogeneous. C is held to 0 <= C <= sqrt(2) 0.23^2, for M
// can vanish where L does not: no energy from the sub-grid scales back to the mesh, and C_s at most 0.23.
const scalar largest = 0.0748119;

// Part of the products in L below which their difference is rounding, and C would be too.
const scalar rounding = 1e-12;

// Least |M| in M:M, over the root of the squares of the two tensors that it is the difference of. In the cells beside a
// wall that holds a uniform stream both are 9/16 of |S| S at the wall: M vanishes there, and C would be what is left of
// L over what is left of M, a million times the rounding of u and another one on every number of ranks.
const scalar least = 0.03;

// L:M and M:M of cells, or of the faces of a patch, from test(u), Sf, test(|S| S) and test(u u).
void contract
(
    scalarField& LM,
    scalarField& MM,
    const vectorField& Uf,
    const symmTensorField& Sf,
    const symmTensorField& fine,
    const symmTensorField& squares,
    const scalarField& delta
)
{
    forAll(LM, i)
    {
        const symmTensor L(dev(squares[i] - sqr(Uf[i])));
        const symmTensor coarse(4.0*mag(Sf[i])*Sf[i]);
        const scalar twice = 2.0*sqr(delta[i]);
        const symmTensor M(twice*(fine[i] - coarse));
        LM[i] = mag(L) > rounding*tr(squares[i]) ? L && M : 0.0;
        MM[i] = max(M && M, sqr(least*twice)*(magSqr(fine[i]) + magSqr(coarse)));
    }
}

class localizedDynamic
:
    public LESeddyViscosity<averagedModel>
{
protected:

    virtual void correctNut()
    {
        const volSymmTensorField S(dev(symm(fvc::grad(U_))));
        const volScalarField magS(mag(S));
        const volVectorField Uf(testFilter(U_));
        const volSymmTensorField Sf(dev(symm(fvc::grad(Uf))));
        const volSymmTensorField fine(testFilter(magS*S));
        const volSymmTensorField squares(testFilter(sqr(U_)));
        volScalarField LM(volScalarField::New("LM", mesh_, dimensionedScalar(dimless, Zero)));
        volScalarField MM("MM", LM);
        contract(LM.primitiveFieldRef(), MM.primitiveFieldRef(), Uf, Sf, fine, squares, delta().primitiveField());
        forAll(LM.boundaryField(), i)
        {
            contract
            (
                LM.boundaryFieldRef()[i], MM.boundaryFieldRef()[i], Uf.boundaryField()[i], Sf.boundaryField()[i],
                fine.boundaryField()[i], squares.boundaryField()[i], delta().boundaryField()[i]
            );
        }
        const volScalarField C(testFilter(LM)/max(testFilter(MM), VSMALL));
        nut_ = min(max(C, scalar(0)), largest)*sqr(delta())*magS;
        nut_.correctBoundaryConditions();
        averagedModel::correctNut();
    }

public:

    TypeName("localizedDynamic");

    localizedDynamic
    (
        const volScalarField& alpha,
        const geometricOneField& rho,
        const volVectorField& U,
        const surfaceScalarField& alphaRhoPhi,
        const surfaceScalarField& phi,
        const singlePhaseTransportModel& transport,
        const word& propertiesName = turbulenceModel::propertiesName,
        const word& type = typeName
    )
    :
        LESeddyViscosity<averagedModel>(type, alpha, rho, U, alphaRhoPhi, phi, transport, propertiesName)
    {
        printCoeffs(type);
    }

    // The energy whose one-equation viscosity is this one (kEqn, C_k = 0.094).
    virtual tmp<volScalarField> k() const { return sqr(nut_/(0.094*delta())); }

    virtual void correct()
    {
        LESeddyViscosity<averagedModel>::correct();
        correctNut();
    }
};

}
}

makeTurbulenceModel(singlePhaseTransportModelaveragedTurbulenceModel, LES, localizedDynamic);
