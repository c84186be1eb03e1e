// The volume-averaged gas on one mesh: fields, equations, and what goes in and out.

#ifndef fbcouple_gas
#define fbcouple_gas

#include "adapter.hpp"
#include "averaged_turbulence.hpp"

namespace fbcouple
{

using namespace Foam;

// Times [s] and superficial velocities [m/s] of an inlet.
typedef List<Tuple2<scalar, scalar>> Table;

// Superficial velocity [m/s], inwards, of what stream k lets in by each face of an inlet: `superficialInletVelocity`.
tmp<scalarField> streamVelocity(const fvPatchVectorField& inlet, const label k);

// Temperature [K] of what comes in now by each face of an opening: `inletOutlet` or `mixedInletTemperature`.
tmp<scalarField> inflowTemperature(const fvPatchScalarField& opening);

class Gas
{
    // Never destroyed, like the gas itself: its end would end the process, also while a constructor throws.
    argList& args_;
    Time time_;
    fvMesh mesh_;
    volVectorField U_;
    volScalarField p_;
    volScalarField eps_;
    surfaceScalarField phi_;
    surfaceScalarField epsPhi_;
    volVectorField gradP_;
    const surfaceVectorField normals_;
    const tensorField inverse_;
    volScalarField dragK_;
    volVectorField dragS_;
    singlePhaseTransportModel transport_;
    autoPtr<averagedModel> turbulence_;
    const dimensionedScalar rho_;
    const int correctors_;
    const bool sharesStress_;
    const bool mendsVelocity_;
    label pRefCell_;
    scalar pRefValue_;
    int iterations_;
    // Step of the gas over the step that the voidage changed in: 1 where steps are equal.
    scalar displaced_;
    // Of an ideal gas: eps rho/rho_0; the temperature at which its density is rho_0 [K]; gravity.
    autoPtr<volScalarField> expanded_;
    dimensionedScalar temperature_;
    dimensionedVector gravity_;

    // Mass of gas in a volume, over rho_0: the voidage where the density is constant.
    const volScalarField& held() const { return expanded_.valid() ? expanded_() : eps_; }
    tmp<volScalarField> heldNow() const;
    void holdAtInlets();
    tmp<volScalarField> storing() const;

    void fill(volScalarField& field, const double* values);
    void fillDrag(const double* sums);
    tmp<volScalarField> stressViscosity() const;
    void setVelocity(const volScalarField& A, const volVectorField& H);
    void correctPressure(const fvVectorMatrix& UEqn);

public:

    Gas(int argc, char** argv, double rho, int correctors);
    void setInlet(const List<Table>& tables);
    void expand(double temperature, double gravity);
    void start(const double* voidage);
    void step(double dt, double moved, const double* voidage, const double* drag);
    void cells(double* centres, double* volumes) const;
    void fields(double* state, double* pressure, double* voidage, double* totals) const;
    void measure(double* values) const;
    void outlets(double* values) const;
    void write();
    word timeName() const { return time_.timeName(); }
    label nCells() const { return mesh_.nCells(); }
    const fvMesh& mesh() const { return mesh_; }
};

}

#endif
