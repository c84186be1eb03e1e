// What the gas tells of itself after a step: its fields, and what went in and out.

#include "gas.hpp"

namespace
{

using namespace Foam;

// The patch outlet or, of several, outlet1 and so on.
bool isOutlet(const fvPatch& patch)
{
    return patch.name().startsWith("outlet");
}

}

namespace fbcouple
{

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

// Courant and Fourier number of the last step, gas volume, at rho_0, that continuity lost in it [m3/s], and, as warm as
// it is there, that came in by the inlet [m3/s], pressure there [Pa], pressure iterations, gas displaced wrongly [m3], and the gas that went out by the
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
        const scalarField thinned(eps_.boundaryField()[patchi]/held().boundaryField()[patchi]);
        in -= expanded_.valid() ? sum(epsPhi_.boundaryField()[patchi]*thinned) : flux;
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

}
