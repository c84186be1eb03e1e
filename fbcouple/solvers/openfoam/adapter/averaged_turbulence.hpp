// The base of the turbulence models of the volume-averaged gas, in place of OpenFOAM's own, whose name, folder and
// abstract functions are not the same in v1912 as in v2012 and later. The models over it are OpenFOAM's templates.

#ifndef fbcouple_averaged_turbulence
#define fbcouple_averaged_turbulence

#include "TurbulenceModel.H"
#include "incompressibleTurbulenceModel.H"
#include "singlePhaseTransportModel.H"

namespace Foam
{

// `alpha` is the voidage, `alphaRhoPhi` the flux eps u.S. The equations of the gas take nothing but nuEff(): the stress
// as a whole, in the forms that one version or another asks for, is refused.
template<class Transport>
class averagedTurbulenceModel
:
    public TurbulenceModel<volScalarField, geometricOneField, incompressibleTurbulenceModel, Transport>
{
    typedef TurbulenceModel<volScalarField, geometricOneField, incompressibleTurbulenceModel, Transport> baseType;

public:

    typedef volScalarField alphaField;
    typedef geometricOneField rhoField;
    typedef Transport transportModel;

    averagedTurbulenceModel
    (
        const word&, // the type, which OpenFOAM's models hand on
        const alphaField& alpha,
        const rhoField& rho,
        const volVectorField& U,
        const surfaceScalarField& alphaRhoPhi,
        const surfaceScalarField& phi,
        const transportModel& transport,
        const word& propertiesName
    )
    :
        baseType(alpha, rho, U, alphaRhoPhi, phi, transport, propertiesName)
    {}

    // The model that constant/turbulenceProperties names.
    static autoPtr<averagedTurbulenceModel> New
    (
        const alphaField& alpha,
        const volVectorField& U,
        const surfaceScalarField& alphaRhoPhi,
        const surfaceScalarField& phi,
        const transportModel& transport,
        const word& propertiesName = turbulenceModel::propertiesName
    )
    {
        auto chosen = baseType::New(alpha, geometricOneField(), U, alphaRhoPhi, phi, transport, propertiesName);
        return autoPtr<averagedTurbulenceModel>(static_cast<averagedTurbulenceModel*>(chosen.ptr()));
    }

    virtual tmp<volSymmTensorField> devReff() const { return refuse<volSymmTensorField>(); }
    virtual tmp<volSymmTensorField> devReff(const volVectorField&) const { return refuse<volSymmTensorField>(); }
    virtual tmp<fvVectorMatrix> divDevReff(volVectorField&) const { return refuse<fvVectorMatrix>(); }

private:

    template<class Type>
    static tmp<Type> refuse()
    {
        FatalErrorInFunction << "the averaged gas has no stress but that of nuEff()" << abort(FatalError);
        return tmp<Type>();
    }
};

typedef averagedTurbulenceModel<singlePhaseTransportModel> averagedModel;

}

#endif
