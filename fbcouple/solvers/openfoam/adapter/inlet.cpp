// A boundary condition of the velocity that OpenFOAM's own lack: `superficialInletVelocity`, put into its selection
// table. At each face it is
//
//   u = -n U(t)/eps
//
// with the outward unit normal n, the voidage eps there and the superficial velocity U(t): the patch carries U times its
// area, whatever way it looks and whatever lies before it. U is a table of times [s] and velocities [m/s], as long as one
// likes, linear between its rows; of two rows at one time the first holds before it and the second from then on.

#include <algorithm>

#include "addToRunTimeSelectionTable.H"
#include "fixedValueFvPatchFields.H"
#include "fvCFD.H"

namespace Foam
{

class superficialInletVelocityFvPatchVectorField
:
    public fixedValueFvPatchVectorField
{
    word voidageName_;
    List<Tuple2<scalar, scalar>> table_;

    scalar velocity(const scalar time) const
    {
        const auto after = std::upper_bound
        (
            table_.begin(), table_.end(), time,
            [](const scalar t, const Tuple2<scalar, scalar>& row) { return t < row.first(); }
        );
        if (after == table_.begin()) return table_.first().second();
        if (after == table_.end()) return table_.last().second();
        const Tuple2<scalar, scalar>& before = *(after - 1);
        const scalar part = (time - before.first())/(after->first() - before.first());
        return before.second() + part*(after->second() - before.second());
    }

    void requireOrder(const dictionary& dict) const
    {
        bool ordered = table_.size() > 0;
        for (label row = 1; row < table_.size(); ++row) ordered &= !(table_[row].first() < table_[row - 1].first());
        if (ordered) return;
        FatalIOErrorInFunction(dict)
            << "patch " << patch().name() << ": `table` needs a row or more of (time velocity), ordered by time"
            << exit(FatalIOError);
    }

public:

    TypeName("superficialInletVelocity");

    superficialInletVelocityFvPatchVectorField(const fvPatch& p, const DimensionedField<vector, volMesh>& iF)
    :
        fixedValueFvPatchVectorField(p, iF),
        voidageName_("voidage"),
        table_(1, Tuple2<scalar, scalar>(0, 0))
    {}

    // At time zero, where no voidage is known yet, `value` is what the table says over a voidage of 1: the one in the
    // deck is for tools that do not know this condition.
    superficialInletVelocityFvPatchVectorField
    (
        const fvPatch& p, const DimensionedField<vector, volMesh>& iF, const dictionary& dict
    )
    :
        fixedValueFvPatchVectorField(p, iF, dict),
        voidageName_(dict.lookupOrDefault<word>("voidage", "voidage")),
        table_(dict.lookup("table"))
    {
        requireOrder(dict);
        const scalar time = db().time().value();
        if (time == 0) fvPatchVectorField::operator==(-velocity(time)*p.nf());
    }

    superficialInletVelocityFvPatchVectorField
    (
        const superficialInletVelocityFvPatchVectorField& other,
        const fvPatch& p, const DimensionedField<vector, volMesh>& iF, const fvPatchFieldMapper& mapper
    )
    :
        fixedValueFvPatchVectorField(other, p, iF, mapper),
        voidageName_(other.voidageName_),
        table_(other.table_)
    {}

    superficialInletVelocityFvPatchVectorField(const superficialInletVelocityFvPatchVectorField& other)
    :
        fixedValueFvPatchVectorField(other),
        voidageName_(other.voidageName_),
        table_(other.table_)
    {}

    superficialInletVelocityFvPatchVectorField
    (
        const superficialInletVelocityFvPatchVectorField& other, const DimensionedField<vector, volMesh>& iF
    )
    :
        fixedValueFvPatchVectorField(other, iF),
        voidageName_(other.voidageName_),
        table_(other.table_)
    {}

    virtual tmp<fvPatchVectorField> clone() const
    {
        return tmp<fvPatchVectorField>(new superficialInletVelocityFvPatchVectorField(*this));
    }

    virtual tmp<fvPatchVectorField> clone(const DimensionedField<vector, volMesh>& iF) const
    {
        return tmp<fvPatchVectorField>(new superficialInletVelocityFvPatchVectorField(*this, iF));
    }

    virtual void updateCoeffs()
    {
        if (updated()) return;
        const fvPatchScalarField& voidage = patch().lookupPatchField<volScalarField, scalar>(voidageName_);
        fvPatchVectorField::operator==(-velocity(db().time().value())*patch().nf()/voidage);
        fixedValueFvPatchVectorField::updateCoeffs();
    }

    virtual void write(Ostream& os) const
    {
        fvPatchVectorField::write(os);
        os.writeEntry("voidage", voidageName_);
        // In text also where fields are written in binary: OpenFOAM's tools, which do not know it, hand it on as it is.
        os.writeKeyword("table") << token::BEGIN_LIST;
        forAll(table_, row) os << nl << table_[row];
        os << token::END_LIST << token::END_STATEMENT << nl;
        writeEntry("value", os);
    }
};

makePatchTypeField(fvPatchVectorField, superficialInletVelocityFvPatchVectorField);

}
