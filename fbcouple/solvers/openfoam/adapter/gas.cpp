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

namespace
{

using namespace Foam;

IOobject described(const word& name, const fvMesh& mesh, IOobject::readOption read)
{
    return IOobject(name, mesh.time().timeName(), mesh, read, IOobject::AUTO_WRITE);
}

// The patch outlet or, of several, outlet1 and so on.
bool isOutlet(const fvPatch& patch)
{
    return patch.name().startsWith("outlet");
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
        const vectorField before(U_.primitiveField());
        const surfaceScalarField ownFlux(oldFlux + transport*epsPhi_ - fvc::flux(carried*U_/eps_));
        surfaceScalarField predicted("predicted", conductance*(fvc::flux(H/eps_) + ownFlux));
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
        const scalarField& near = local.primitiveField();
        gradP_.primitiveFieldRef() =
            (H.primitiveField() - carried.primitiveField()*before - near*U_.primitiveField())/eps_.primitiveField();
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

void Gas::cells(double* centres, double* volumes) const
{
    forAll(mesh_.V(), i)
    {
        for (direction d = 0; d < 3; ++d) centres[3*i + d] = mesh_.C()[i][d];
        volumes[i] = mesh_.V()[i];
    }
}

// Rows of velocity [m/s] and pressure gradient [Pa/m] as the momentum equation used it; pressure [Pa]; voidage. The
// totals, over this rank's cells: V (K u - S), alpha V grad P, alpha V, and the pressures, so that one number that is
// none shows.
void Gas::fields(double* state, double* pressure, double* voidage, double* totals) const
{
    const vectorField& U = U_.primitiveField();
    const vectorField& gradP = gradP_.primitiveField();
    const scalarField& p = p_.primitiveField();
    const scalarField& eps = eps_.primitiveField();
    const scalarField& K = dragK_.primitiveField();
    const vectorField& S = dragS_.primitiveField();
    const scalarField& V = mesh_.V();
    const scalar rho = rho_.value();
    vector drag = Zero, push = Zero;
    scalar solids = 0, pressures = 0;
    forAll(U, i)
    {
        const vector slope = rho*gradP[i];
        voidage[i] = eps[i];
        const scalar solid = (1.0 - eps[i])*V[i];
        drag += V[i]*(K[i]*U[i] - S[i]);
        push += solid*slope;
        solids += solid;
        pressures += pressure[i] = rho*p[i];
        for (direction d = 0; d < 3; ++d)
        {
            state[6*i + d] = U[i][d];
            state[6*i + 3 + d] = slope[d];
        }
    }
    for (direction d = 0; d < 3; ++d)
    {
        totals[d] = drag[d];
        totals[3 + d] = push[d];
    }
    totals[6] = solids;
    totals[7] = pressures;
}

// Courant and Fourier number of the last step, gas volume, at rho_0, that continuity lost in it [m3/s], and that came in
// by the inlet [m3/s], pressure there [Pa], pressure iterations, gas displaced wrongly [m3], and the gas that went out by the
// outlet and that came in by it [m3/s]. The same on every rank.
void Gas::measure(double* values) const
{
    const scalar dt = time_.deltaTValue();
    const scalarField sumPhi(fvc::surfaceSum(mag(phi_))().primitiveField());
    values[0] = 0.5*gMax(sumPhi/mesh_.V().field())*dt;
    const volScalarField nuEff(turbulence_->nuEff());
    const scalarField spread(fvc::surfaceSum(mesh_.magSf()*mesh_.deltaCoeffs())().primitiveField());
    values[1] = gMax(nuEff.primitiveField()*spread/mesh_.V().field())*dt;
    vector flows = Zero;
    scalar& in = flows[0];
    scalar& out = flows[1];
    scalar& back = flows[2];
    vector2D inlet = Zero;
    scalar& pIn = inlet[0];
    scalar& area = inlet[1];
    forAll(mesh_.boundary(), patchi)
    {
        if (mesh_.boundary()[patchi].coupled()) continue;
        const fvPatch& patch = mesh_.boundary()[patchi];
        const scalar flux = sum(epsPhi_.boundaryField()[patchi]);
        out += flux;
        if (isOutlet(patch)) back -= sum(min(epsPhi_.boundaryField()[patchi], scalar(0)));
        if (patch.name() != "inlet") continue;
        in -= flux;
        const scalarField rise((gradP_.boundaryField()[patchi].patchInternalField() & patch.nf())/patch.deltaCoeffs());
        pIn += sum((p_.boundaryField()[patchi].patchInternalField() + rise)*patch.magSf());
        area += sum(patch.magSf());
    }
    const scalarField change((eps_.primitiveField() - eps_.oldTime().primitiveField())*mesh_.V().field());
    const scalar stored =
        expanded_.valid() ? gSum(storing()().primitiveField()*mesh_.V().field()) : displaced_*gSum(change)/dt;
    reduce(flows, sumOp<vector>());
    reduce(inlet, sumOp<vector2D>());
    values[2] = mag(stored + out);
    values[3] = in;
    values[4] = area > 0 ? rho_.value()*pIn/area : 0;
    values[5] = iterations_;
    values[6] = displaced_ == 1 ? 0 : mag(displaced_ - 1)*gSumMag(change);
    values[7] = max(out + in + back, scalar(0));
    values[8] = back;
}

// Of each outlet, in their order, the gas that went out by it and that came in by it [m3/s]. The same on every rank.
void Gas::outlets(double* values) const
{
    label number = 0;
    forAll(mesh_.boundary(), patchi)
    {
        if (!isOutlet(mesh_.boundary()[patchi])) continue;
        const scalarField& flux = epsPhi_.boundaryField()[patchi];
        values[number++] = gSum(max(flux, scalar(0)));
        values[number++] = -gSum(min(flux, scalar(0)));
    }
}

void Gas::write()
{
    time_.writeNow();
}

}
