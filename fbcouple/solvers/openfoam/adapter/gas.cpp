// The volume-averaged gas (model A) on OpenFOAM's own finite-volume operators.
//
//   d(eps)/dt + div(eps u) = 0
//   d(eps u)/dt + div(eps u u) = -eps grad(p) + div(eps tau) + (S - K u)/rho
//
// Hamidouche et al. 2019, eqs 3-4 with the particle source of eq. 29: -(F_D + F_P) leaves eps grad P, once. p is the
// dynamic pressure over rho, K [kg m-3 s-1] the implicit and S [N m-3] the explicit part of the drag. Gravity is
// absorbed in p; the buoyancy of the particles is given to them with their pressure-gradient force.
//
// An ideal gas has eps rho/rho_0 in place of eps in all terms of mass, with rho/rho_0 = T_0/T of the temperature that the
// last step left, its flux is that of mass over rho_0, and what it is lighter by than rho_0 drives it upwards. The
// pressure that its density has is constant: sound takes no time.

#include "gas.hpp"
#include "inletOutletFvPatchFields.H"

namespace
{

using namespace Foam;

IOobject described(const word& name, const fvMesh& mesh, IOobject::readOption read)
{
    return IOobject(name, mesh.time().timeName(), mesh, read, IOobject::AUTO_WRITE);
}

}

namespace fbcouple
{

Gas::Gas(int argc, char** argv, double rho, int correctors)
:
    args_(*new argList(argc, argv)),
    time_(Time::controlDictName, args_),
    mesh_(IOobject(fvMesh::defaultRegion, time_.timeName(), time_, IOobject::MUST_READ)),
    U_(described("U", mesh_, IOobject::MUST_READ), mesh_),
    p_(described("p", mesh_, IOobject::MUST_READ), mesh_),
    eps_(described("voidage", mesh_, IOobject::MUST_READ), mesh_),
    phi_(described("phi", mesh_, IOobject::READ_IF_PRESENT), fvc::flux(U_)),
    epsPhi_(described("voidagePhi", mesh_, IOobject::READ_IF_PRESENT), fvc::interpolate(eps_)*phi_),
    gradP_("gradP", fvc::grad(p_)),
    normals_(mesh_.Sf()/mesh_.magSf()),
    inverse_(inv(fvc::surfaceSum(normals_*mesh_.Sf())().primitiveField())),
    dragK_
    (
        IOobject("dragK", time_.timeName(), mesh_), mesh_,
        dimensionedScalar(dimDensity/dimTime, Zero), zeroGradientFvPatchScalarField::typeName
    ),
    dragS_
    (
        IOobject("dragS", time_.timeName(), mesh_), mesh_,
        dimensionedVector(dimDensity*dimAcceleration, Zero), zeroGradientFvPatchVectorField::typeName
    ),
    transport_(U_, phi_),
    turbulence_(averagedModel::New(eps_, U_, epsPhi_, phi_, transport_)),
    rho_("rho", dimDensity, rho),
    correctors_(correctors),
    sharesStress_(mesh_.solutionDict().subOrEmptyDict("PISO").lookupOrDefault<bool>("viscousForceOnParticles", false)),
    mendsVelocity_(mesh_.solutionDict().subOrEmptyDict("PISO").lookupOrDefault<bool>("velocityFromMomentum", false)),
    pRefCell_(0),
    pRefValue_(0),
    iterations_(0),
    displaced_(1),
    temperature_("temperature", dimTemperature, Zero),
    gravity_("gravity", dimAcceleration, Zero)
{
    // The name of a time directory has 12 digits; a gas that goes on from one needs the time itself.
    const IOdictionary stored
    (
        IOobject("time", time_.timeName(), "uniform", time_, IOobject::READ_IF_PRESENT, IOobject::NO_WRITE, false)
    );
    scalar value;
    if (stored.readIfPresent("value", value)) time_.setTime(value, time_.timeIndex());
    setRefCell(p_, mesh_.solutionDict().subOrEmptyDict("PISO"), pRefCell_, pRefValue_);
    mesh_.setFluxRequired(p_.name());
    U_.oldTime();
    eps_.oldTime();
    epsPhi_.oldTime();
    turbulence_->validate();
}

void Gas::fill(volScalarField& field, const double* values)
{
    scalarField& inside = field.primitiveFieldRef();
    forAll(inside, i) inside[i] = values[i];
    field.correctBoundaryConditions();
}

// K and S from rows of what the drag of a cell's particles adds up to: beta [kg/s] and beta v [N].
void Gas::fillDrag(const double* sums)
{
    scalarField& implicitPart = dragK_.primitiveFieldRef();
    vectorField& explicitPart = dragS_.primitiveFieldRef();
    const scalarField& volumes = mesh_.V();
    forAll(implicitPart, i)
    {
        const double* row = sums + 4*i;
        const scalar share = 1.0/volumes[i];
        implicitPart[i] = share*row[0];
        explicitPart[i] = vector(share*row[1], share*row[2], share*row[3]);
    }
    dragK_.correctBoundaryConditions();
    dragS_.correctBoundaryConditions();
}

tmp<volScalarField> Gas::heldNow() const
{
    return eps_*temperature_/mesh_.lookupObject<volScalarField>("T");
}

// What comes in by an inlet has its own temperature, and what goes out by one that of the cell, in the step in which the
// flow there begins or turns as well: T goes by the flux of the step before.
void Gas::holdAtInlets()
{
    const volScalarField& T = mesh_.lookupObject<volScalarField>("T");
    forAll(mesh_.boundary(), patchi)
    {
        const fvPatchScalarField& Tp = T.boundaryField()[patchi];
        const fvPatchVectorField& Up = U_.boundaryField()[patchi];
        if (!Up.fixesValue() || !isA<inletOutletFvPatchScalarField>(Tp)) continue;
        const scalarField inflow(inflowTemperature(Tp));
        const scalarField inside(Tp.patchInternalField());
        const vectorField& Sf = Up.patch().Sf();
        scalarField& heldp = expanded_().boundaryFieldRef()[patchi];
        forAll(heldp, face)
        {
            const scalar there = (Up[face] & Sf[face]) < 0 ? inflow[face] : inside[face];
            heldp[face] = eps_.boundaryField()[patchi][face]*temperature_.value()/there;
        }
    }
}

// From now on the density follows the temperature, as that of an ideal gas does that has rho_0 at `temperature` [K];
// `gravity` [m/s2] pulls downwards. A gas that goes on has what it held from where it goes on.
void Gas::expand(double temperature, double gravity)
{
    temperature_.value() = temperature;
    gravity_.value() = vector(0, 0, -gravity);
    expanded_.reset(new volScalarField(described("gasHeld", mesh_, IOobject::READ_IF_PRESENT), heldNow()));
    expanded_().oldTime();
}

// The voidage of the first step: no particle has moved yet, so d(eps)/dt starts from zero.
void Gas::start(const double* voidage)
{
    fill(eps_, voidage);
    eps_.oldTime() == eps_;
    U_.correctBoundaryConditions();
    phi_ = fvc::flux(U_);
    if (expanded_.valid())
    {
        expanded_() == heldNow();
        expanded_().oldTime() == expanded_();
    }
    epsPhi_ = fvc::interpolate(held())*phi_;
    epsPhi_.oldTime() == epsPhi_;
}

// Cell velocity from the face fluxes: the mean of opposite faces on a hexahedron. Of other cells only a uniform flow
// comes back from its fluxes; there they mend the velocity that the momentum equation gives.
void Gas::setVelocity(const volScalarField& A, const volVectorField& H)
{
    tmp<surfaceScalarField> fluxes(epsPhi_);
    if (mendsVelocity_)
    {
        U_.primitiveFieldRef() =
            (H.primitiveField() - eps_.primitiveField()*fvc::grad(p_)().primitiveField())/A.primitiveField();
        U_.correctBoundaryConditions();
        fluxes = epsPhi_ - fvc::flux(held()*U_);
    }
    else U_.primitiveFieldRef() = Zero;
    const tmp<volVectorField> sums(fvc::surfaceSum(normals_*fluxes));
    U_.primitiveFieldRef() += (inverse_ & sums().primitiveField())/held().primitiveField();
    U_.correctBoundaryConditions();
}

// With a viscous force on the particles the gas keeps eps div(tau): div(tau) here, less what they take, in S. Without
// it the gas has all of the averaged stress, div(eps tau).
tmp<volScalarField> Gas::stressViscosity() const
{
    if (expanded_.valid()) return eps_*turbulence_->nu() + held()*turbulence_->nut();
    return sharesStress_ ? turbulence_->nuEff() : eps_*turbulence_->nuEff();
}

// What the cells take in of gas a second, over rho_0: what the particles leave to it, as of the step in which they moved,
// and what its density gains.
tmp<volScalarField> Gas::storing() const
{
    if (!expanded_.valid()) return displaced_*fvc::ddt(eps_);
    return fvc::ddt(held()) + (displaced_ - 1)*held()/eps_*fvc::ddt(eps_);
}

// The momentum equation of a cell, A U = H - eps grad(p), read on both halves of the way between two cells, with one
// flux q = eps U.S and one pressure at the face, gives q (A/eps^2)_f = (H/eps)_f.S - dp/dn; of an ideal gas with q the
// flux of what it holds, and that in place of one of the two eps. Drag and voidage may jump
// between the cells: a packed bed with a sharp surface stays exact, where the usual interpolation of H/A and a Gauss
// gradient lets the cells on both sides of the surface accelerate. The velocity of a cell then follows its faces,
// and grad(p) of a cell is what its momentum equation leaves, so that gas and particles share one gradient.
void Gas::correctPressure(const fvVectorMatrix& UEqn)
{
    const volScalarField A(UEqn.A());
    const volScalarField& held = this->held();
    const volScalarField local("local", held/time_.deltaT() + dragK_/rho_);
    const surfaceScalarField heldf(fvc::interpolate(held));
    const surfaceScalarField conductance("conductance", 1.0/fvc::interpolate(A/(eps_*held)));
    // What a face carries itself is not taken from the mean over the cells, which would diffuse it: its old flux, and
    // its part in the diagonal of convection and diffusion, so that these act as they do in the cells. What is taken
    // away is interpolated as H/eps is, or the difference, O(dx^2), would be divided by dt or dx^2.
    const volScalarField carried("carried", A - local);
    const surfaceScalarField transport(fvc::interpolate(carried/(eps_*held)));
    const surfaceScalarField oldFlux
    (
        (epsPhi_.oldTime()*fvc::interpolate(1.0/eps_) - fvc::flux(held.oldTime()*U_.oldTime()/eps_))/time_.deltaT()
    );
    for (int corr = 0; corr < correctors_; ++corr)
    {
        const volVectorField H(UEqn.H());
        const volVectorField rest(H - carried*U_);
        surfaceScalarField predicted("predicted", conductance*(fvc::flux(rest/eps_) + oldFlux + transport*epsPhi_));
        forAll(U_.boundaryField(), patchi)
        {
            const fvPatchVectorField& Up = U_.boundaryField()[patchi];
            if (Up.coupled() || p_.boundaryField()[patchi].fixesValue()) continue;
            predicted.boundaryFieldRef()[patchi] = heldf.boundaryField()[patchi]*(Up & Up.patch().Sf());
        }
        fvScalarMatrix pEqn(fvm::laplacian(conductance, p_) == storing() + fvc::div(predicted));
        if (p_.needReference()) pEqn.setReference(pRefCell_, pRefValue_);
        const bool last = corr == correctors_ - 1;
        iterations_ += pEqn.solve(mesh_.solver(p_.select(last))).nIterations();
        epsPhi_ = predicted - pEqn.flux();
        setVelocity(A, H);
        if (!last) continue;
        gradP_.primitiveFieldRef() =
            (rest.primitiveField() - local.primitiveField()*U_.primitiveField())/eps_.primitiveField();
    }
    phi_ = epsPhi_/heldf;
}

// The voidage changed while the particles moved, for `moved` [s], a step that was longer or shorter than `dt`: what they
// displace a second is that change over `moved`, dt/moved times what fvc::ddt makes of it. The momentum equation has no
// part in this, since its d(eps)/dt cancels. Advance time first, touch the old levels, then write the new voidage:
// written earlier it would be taken for the old.
void Gas::step(double dt, double moved, const double* voidage, const double* drag)
{
    displaced_ = dt/moved;
    time_.setDeltaT(dt);
    ++time_;
    U_.oldTime();
    epsPhi_.oldTime();
    eps_.oldTime();
    held().oldTime();
    fill(eps_, voidage);
    if (expanded_.valid()) expanded_() == heldNow();
    fillDrag(drag);
    U_.correctBoundaryConditions();
    if (expanded_.valid()) holdAtInlets();
    iterations_ = 0;

    fvVectorMatrix UEqn
    (
        fvm::ddt(held(), U_) + fvm::div(epsPhi_, U_)
      - fvm::Sp(fvc::ddt(held()) + fvc::div(epsPhi_), U_)
      - viscousForce(stressViscosity(), U_)
      + fvm::Sp(dragK_/rho_, U_)
     ==
        dragS_/rho_
    );
    if (expanded_.valid()) UEqn -= (held() - eps_)*gravity_;
    correctPressure(UEqn);
    turbulence_->correct();
}

void Gas::write()
{
    time_.writeNow();
}

}
