// A boundary condition of the temperature that OpenFOAM's own lack: `mixedInletTemperature`, put into its selection table.
// As `inletOutlet`, what goes out has the temperature of the cell; what comes in by a face is the mixture of what its
// inlets let in there, of as much heat:
//
//   T = sum_k q_k T_k/sum_k q_k
//
// with the temperature T_k and the mass flux q_k of inlet k, which is as its superficial velocity at the face or, of an
// ideal gas at one pressure, as that over T_k. An inlet by which gas leaves has no part in it.

#include "addToRunTimeSelectionTable.H"
#include "gas.hpp"
#include "inletOutletFvPatchFields.H"

namespace Foam
{

class mixedInletTemperatureFvPatchScalarField
:
    public inletOutletFvPatchScalarField
{
    // Of each table of the velocity.
    DynamicList<scalar> temperatures_;
    bool idealGas_;

    static word number(const label k) { return "temperature" + Foam::name(k + 1); }

public:

    TypeName("mixedInletTemperature");

    mixedInletTemperatureFvPatchScalarField(const fvPatch& p, const DimensionedField<scalar, volMesh>& iF)
    :
        inletOutletFvPatchScalarField(p, iF),
        idealGas_(false)
    {}

    mixedInletTemperatureFvPatchScalarField
    (
        const fvPatch& p, const DimensionedField<scalar, volMesh>& iF, const dictionary& dict
    )
    :
        inletOutletFvPatchScalarField(p, iF, dict),
        idealGas_(readBool(dict.lookup("idealGas")))
    {
        for (label k = 0; k == 0 || dict.found(number(k)); ++k)
        {
            temperatures_.append(readScalar(dict.lookup(number(k))));
        }
    }

    mixedInletTemperatureFvPatchScalarField
    (
        const mixedInletTemperatureFvPatchScalarField& other,
        const fvPatch& p, const DimensionedField<scalar, volMesh>& iF, const fvPatchFieldMapper& mapper
    )
    :
        inletOutletFvPatchScalarField(other, p, iF, mapper),
        temperatures_(other.temperatures_),
        idealGas_(other.idealGas_)
    {}

    mixedInletTemperatureFvPatchScalarField(const mixedInletTemperatureFvPatchScalarField& other)
    :
        inletOutletFvPatchScalarField(other),
        temperatures_(other.temperatures_),
        idealGas_(other.idealGas_)
    {}

    mixedInletTemperatureFvPatchScalarField
    (
        const mixedInletTemperatureFvPatchScalarField& other, const DimensionedField<scalar, volMesh>& iF
    )
    :
        inletOutletFvPatchScalarField(other, iF),
        temperatures_(other.temperatures_),
        idealGas_(other.idealGas_)
    {}

    virtual tmp<fvPatchScalarField> clone() const
    {
        return tmp<fvPatchScalarField>(new mixedInletTemperatureFvPatchScalarField(*this));
    }

    virtual tmp<fvPatchScalarField> clone(const DimensionedField<scalar, volMesh>& iF) const
    {
        return tmp<fvPatchScalarField>(new mixedInletTemperatureFvPatchScalarField(*this, iF));
    }

    // Where nothing comes in it stays what it was, and counts for nothing.
    tmp<scalarField> mixture() const
    {
        const fvPatchVectorField& U = patch().lookupPatchField<volVectorField, vector>("U");
        scalarField flow(size(), Zero);
        scalarField heat(size(), Zero);
        forAll(temperatures_, k)
        {
            const scalarField inwards(max(fbcouple::streamVelocity(U, k), scalar(0)));
            const scalarField mass(inwards/(idealGas_ ? temperatures_[k] : 1.0));
            flow += mass;
            heat += mass*temperatures_[k];
        }
        tmp<scalarField> mixed(new scalarField(refValue()));
        forAll(flow, face) if (flow[face] > 0) mixed.ref()[face] = heat[face]/flow[face];
        return mixed;
    }

    virtual void updateCoeffs()
    {
        if (updated()) return;
        refValue() = mixture();
        inletOutletFvPatchScalarField::updateCoeffs();
    }

    virtual void write(Ostream& os) const
    {
        inletOutletFvPatchScalarField::write(os);
        os.writeEntry("idealGas", word(idealGas_ ? "yes" : "no"));
        forAll(temperatures_, k) os.writeEntry(number(k), temperatures_[k]);
    }
};

makePatchTypeField(fvPatchScalarField, mixedInletTemperatureFvPatchScalarField);

}

Foam::tmp<Foam::scalarField> fbcouple::inflowTemperature(const fvPatchScalarField& opening)
{
    typedef mixedInletTemperatureFvPatchScalarField Inlet;
    if (isA<Inlet>(opening)) return refCast<const Inlet>(opening).mixture();
    return tmp<scalarField>(new scalarField(refCast<const inletOutletFvPatchScalarField>(opening).refValue()));
}
