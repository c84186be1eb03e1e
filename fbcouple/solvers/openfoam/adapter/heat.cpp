// The enthalpy of the volume-averaged gas, passive, after the step of its momentum; nothing here runs unless asked.
//
//   d(eps rho cp T)/dt + div(eps rho cp u T) = div(k grad T) + S - K T + walls
//
// with the flux eps u.S and the voidage that the momentum and the pressure equation had, in the form that leaves a
// uniform temperature as it is where continuity is not exact: T (d(eps)/dt + div(eps u)) is taken off, and its heat is
// told. An ideal gas has eps rho/rho_0 in place of eps. k [W/(m K)] is the conductivity of the cells, eps that of the gas or the bed's, and beside it eps rho cp nu_t/Pr_t.
// K [W/K] and S [W] come from the particles of a cell. All heat is counted from the reference temperature.

#include <cstdint>
#include <stdexcept>

#include "adapter.hpp"
#include "mixedFvPatchFields.H"
#include "turbulenceModel.H"

namespace
{

using namespace Foam;

// What a step did to the heat of the gas [J], over this rank's cells: held before and after it; that came in by walls,
// inlets and outlets; that continuity made; that the particles gave; and the sum of its magnitudes.
enum Amount { before, after, byWalls, byInlets, byOutlets, byContinuity, byParticles, magnitude, amounts };

class Heat
{
    const fvMesh& mesh_;
    const volScalarField& eps_;
    const surfaceScalarField& epsPhi_;

    // Mass of gas in a volume, over its density at the reference temperature.
    const volScalarField& held() const
    {
        return mesh_.foundObject<volScalarField>("gasHeld") ? mesh_.lookupObject<volScalarField>("gasHeld") : eps_;
    }

    // Heat capacity of the gas [J/(m3 K)], its reference temperature [K], turbulent Prandtl number or 0.
    const scalar capacity_;
    const scalar reference_;
    const scalar turbulentPrandtl_;
    // Coefficients of walls count on the share of a wall that the gas touches, eps, or on the whole.
    const bool onVoidage_;
    volScalarField T_;
    volScalarField diffusivity_;
    // Of each cell the sum of h A of its walls [m3/s], and that of h A T_w [m3 K/s], both over the heat capacity.
    scalarField film_;
    scalarField filmSource_;
    volScalarField given_;
    volScalarField taken_;

    static bool isWall(const fvPatchScalarField& patch) { return patch.type() == mixedFvPatchScalarField::typeName; }
    label findSide(const fvPatch& patch, label face) const;
    void setWalls(const double* walls);
    scalar share(label cell) const { return onVoidage_ ? eps_[cell] : 1.0; }
    void fill(const double* conductivity, const double* sums);
    void count(const fvScalarMatrix& equation, const scalarField& lost, double* values) const;

public:

    Heat(scalar capacity, scalar reference, scalar turbulentPrandtl, const double* walls, bool onVoidage);
    void step(const double* conductivity, const double* sums, double* values);
    const scalarField& temperatures() const { return T_.primitiveField(); }
};

volScalarField* makeField(const word& name, const fvMesh& mesh, const dimensionSet& dimensions)
{
    return new volScalarField
    (
        IOobject(name, mesh.time().timeName(), mesh), mesh,
        dimensionedScalar(dimensions, Zero), zeroGradientFvPatchScalarField::typeName
    );
}

Heat::Heat(scalar capacity, scalar reference, scalar turbulentPrandtl, const double* walls, bool onVoidage)
:
    mesh_(gasMesh()),
    eps_(mesh_.lookupObject<volScalarField>("voidage")),
    epsPhi_(mesh_.lookupObject<surfaceScalarField>("voidagePhi")),
    capacity_(capacity),
    reference_(reference),
    turbulentPrandtl_(turbulentPrandtl),
    onVoidage_(onVoidage),
    T_(IOobject("T", mesh_.time().timeName(), mesh_, IOobject::MUST_READ, IOobject::AUTO_WRITE), mesh_),
    diffusivity_(tmp<volScalarField>(makeField("diffusivity", mesh_, dimViscosity))),
    film_(mesh_.nCells(), Zero),
    filmSource_(mesh_.nCells(), Zero),
    given_(tmp<volScalarField>(makeField("heatGiven", mesh_, dimTemperature/dimTime))),
    taken_(tmp<volScalarField>(makeField("heatTaken", mesh_, dimless/dimTime)))
{
    setWalls(walls);
    T_.correctBoundaryConditions();
    T_.oldTime();
}

// The side of the box around the mesh that a face lies on: 1 to 6 for low and high x, y, z, or 0.
label Heat::findSide(const fvPatch& patch, label face) const
{
    const boundBox& box = mesh_.bounds();
    const vector normal(patch.Sf()[face]/patch.magSf()[face]);
    const vector& centre = patch.Cf()[face];
    for (direction d = 0; d < 3; ++d)
    {
        const scalar near = 1e-6*box.span()[d];
        if (normal[d] < -0.99 && mag(centre[d] - box.min()[d]) < near) return 1 + 2*d;
        if (normal[d] > 0.99 && mag(centre[d] - box.max()[d]) < near) return 2 + 2*d;
    }
    return 0;
}

// `walls`: rows of temperature [K] and coefficient [W/(m2 K)], the first of what lies on no side of the box; a number
// that is none where there is none. A wall without a temperature is adiabatic; with one alone the gas at it has that; a
// coefficient counts from the gas in the cell to the wall.
void Heat::setWalls(const double* walls)
{
    volScalarField::Boundary& boundary = T_.boundaryFieldRef();
    forAll(boundary, patchi)
    {
        const fvPatch& patch = mesh_.boundary()[patchi];
        if (!isWall(boundary[patchi])) continue;
        mixedFvPatchScalarField& wall = refCast<mixedFvPatchScalarField>(boundary[patchi]);
        wall.refGrad() = Zero;
        forAll(patch, face)
        {
            const double* row = walls + 2*findSide(patch, face);
            const bool isHot = row[0] == row[0];
            const bool hasFilm = row[1] == row[1];
            wall.refValue()[face] = isHot ? row[0] : reference_;
            wall.valueFraction()[face] = isHot && !hasFilm;
            if (!isHot || !hasFilm) continue;
            const scalar conductance = row[1]*patch.magSf()[face]/capacity_;
            film_[patch.faceCells()[face]] += conductance;
            filmSource_[patch.faceCells()[face]] += conductance*row[0];
        }
    }
}

void Heat::fill(const double* conductivity, const double* sums)
{
    scalarField& diffusivity = diffusivity_.primitiveFieldRef();
    scalarField& given = given_.primitiveFieldRef();
    scalarField& taken = taken_.primitiveFieldRef();
    const scalarField& V = mesh_.V();
    forAll(V, i)
    {
        const scalar perHeat = 1.0/(capacity_*V[i]);
        const scalar perFilm = share(i)/V[i];
        diffusivity[i] = conductivity[i]/capacity_;
        taken[i] = perHeat*sums[2*i] + perFilm*film_[i];
        given[i] = perHeat*(sums[2*i + 1] + reference_*sums[2*i]) + perFilm*filmSource_[i];
    }
    if (turbulentPrandtl_ > 0)
    {
        const tmp<volScalarField> nut(mesh_.lookupObject<turbulenceModel>(turbulenceModel::propertiesName).nut());
        diffusivity += held().primitiveField()*nut().primitiveField()/turbulentPrandtl_;
    }
    diffusivity_.correctBoundaryConditions();
}

void Heat::step(const double* conductivity, const double* sums, double* values)
{
    T_.oldTime();
    fill(conductivity, sums);
    const volScalarField lost(fvc::ddt(held()) + fvc::div(epsPhi_));
    fvScalarMatrix equation
    (
        fvm::ddt(held(), T_) + fvm::div(epsPhi_, T_) - fvm::Sp(lost, T_)
      - fvm::laplacian(diffusivity_, T_) + fvm::Sp(taken_, T_)
     ==
        given_
    );
    equation.solve();
    count(equation, lost.primitiveField(), values);
    forAll(mesh_.V(), i)
    {
        const scalar film = share(i)*(filmSource_[i] - film_[i]*T_[i]);
        const scalar warm = T_[i] - reference_;
        values[byWalls] += capacity_*mesh_.time().deltaTValue()*film;
        values[byParticles] += mesh_.time().deltaTValue()*(sums[2*i + 1] - sums[2*i]*warm);
    }
}

// What left a cell by a face of the boundary is what its equation has of it, convection and conduction together.
void Heat::count(const fvScalarMatrix& equation, const scalarField& lost, double* values) const
{
    for (int n = 0; n < amounts; ++n) values[n] = 0;
    const scalar dt = mesh_.time().deltaTValue();
    const scalarField& old = T_.oldTime().primitiveField();
    const scalarField& now = held().primitiveField();
    const scalarField& then = held().oldTime().primitiveField();
    const scalarField& T = T_.primitiveField();
    const scalarField& V = mesh_.V();
    forAll(T, i)
    {
        const scalar warm = T[i] - reference_;
        const scalar held = capacity_*V[i]*now[i]*warm;
        values[before] += capacity_*V[i]*then[i]*(old[i] - reference_);
        values[after] += held;
        values[magnitude] += mag(held);
        values[byContinuity] += capacity_*V[i]*lost[i]*warm*dt;
    }
    forAll(T_.boundaryField(), patchi)
    {
        const fvPatchScalarField& patch = T_.boundaryField()[patchi];
        if (patch.coupled()) continue;
        const labelUList& cells = patch.patch().faceCells();
        const scalarField& own = equation.internalCoeffs()[patchi];
        const scalarField& fixed = equation.boundaryCoeffs()[patchi];
        scalar out = 0;
        forAll(patch, face)
        {
            out += own[face]*T[cells[face]] - fixed[face] - reference_*epsPhi_.boundaryField()[patchi][face];
        }
        const word& name = patch.patch().name();
        const bool isOpen = !isWall(patch) && (name == "inlet" || name.startsWith("outlet"));
        values[isOpen ? (name == "inlet" ? byInlets : byOutlets) : byWalls] -= capacity_*dt*out;
    }
}

// Never destroyed, like the gas.
Heat* heat = nullptr;

}

extern "C"
{

// Heat capacity of the gas [J/(m3 K)], reference temperature [K], turbulent Prandtl number, 0 of a gas without a model,
// and rows (7, 2) of walls, whose coefficients count on the share of them that the gas touches or on the whole.
int gas_heat_open(double capacity, double reference, double turbulentPrandtl, const double* walls, int onVoidage)
{
    return guarded([&]
    {
        if (heat) throw std::runtime_error("one gas a process");
        heat = new Heat(capacity, reference, turbulentPrandtl, walls, onVoidage != 0);
    });
}

// After the step of the gas: conductivity [W/(m K)] of the cells, rows of K [W/K] and S [W]; the amounts of the step.
int gas_heat_step(const double* conductivity, const double* sums, double* values)
{
    return guarded([&] { heat->step(conductivity, sums, values); });
}

int gas_temperatures(double* values)
{
    return guarded([&]
    {
        const scalarField& T = heat->temperatures();
        forAll(T, i) values[i] = T[i];
    });
}

}
