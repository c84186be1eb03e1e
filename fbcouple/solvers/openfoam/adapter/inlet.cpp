// A boundary condition of the velocity that OpenFOAM's own lack: `superficialInletVelocity`, put into its selection
// table. At each face it is
//
//   u = -n sum_k s_k U_k(t)/eps
//
// with the outward unit normal n, the voidage eps there and the superficial velocity U_k(t) of inlet k, of whose area the
// face has the part s_k of its own: the patch carries U times the area of each inlet, whatever way it looks, whatever
// lies before it and wherever its edge cuts a face. U is a table of times [s] and velocities [m/s], as long as one likes,
// linear between its rows; of two rows at one time the first holds before it and the second from then on. One inlet that
// has all of its faces is the entry `table`; several, or one that cuts faces, are `table1`, `share1`, `table2`, ...

#include <algorithm>

#include "addToRunTimeSelectionTable.H"
#include "fixedValueFvPatchFields.H"
#include "gas.hpp"

namespace Foam
{

class superficialInletVelocityFvPatchVectorField
:
    public fixedValueFvPatchVectorField
{
    typedef fbcouple::Table Table;

    word voidageName_;
    List<Table> tables_;
    // Of each table the part of the faces; none where there is one table and it has all of them.
    List<scalarField> shares_;

    static scalar velocity(const Table& table, const scalar time)
    {
        const auto after = std::upper_bound
        (
            table.begin(), table.end(), time,
            [](const scalar t, const Tuple2<scalar, scalar>& row) { return t < row.first(); }
        );
        if (after == table.begin()) return table.first().second();
        if (after == table.end()) return table.last().second();
        const Tuple2<scalar, scalar>& before = *(after - 1);
        const scalar part = (time - before.first())/(after->first() - before.first());
        return before.second() + part*(after->second() - before.second());
    }

    // The superficial velocity of each face, inwards.
    tmp<scalarField> velocities() const
    {
        tmp<scalarField> sum(new scalarField(size(), Zero));
        forAll(tables_, k) sum.ref() += velocities(k);
        return sum;
    }

    static word number(const word& name, const label k)
    {
        return name + Foam::name(k + 1);
    }

    void readTables(const dictionary& dict)
    {
        if (dict.found("table"))
        {
            tables_.append(Table(dict.lookup("table")));
            requireOrder(dict, tables_.last());
            return;
        }
        for (label k = 0; k == 0 || dict.found(number("table", k)); ++k)
        {
            tables_.append(Table(dict.lookup(number("table", k))));
            requireOrder(dict, tables_.last());
            shares_.append(scalarField(number("share", k), dict, size()));
        }
    }

    void requireOrder(const dictionary& dict, const Table& table) const
    {
        bool ordered = table.size() > 0;
        for (label row = 1; row < table.size(); ++row) ordered &= !(table[row].first() < table[row - 1].first());
        if (ordered) return;
        FatalIOErrorInFunction(dict)
            << "patch " << patch().name() << ": `table` needs a row or more of (time velocity), ordered by time"
            << exit(FatalIOError);
    }

    // In text also where fields are written in binary: OpenFOAM's tools, which do not know it, hand it on as it is.
    static void writeTable(Ostream& os, const word& name, const Table& table)
    {
        os.writeKeyword(name) << token::BEGIN_LIST;
        forAll(table, row) os << nl << table[row];
        os << token::END_LIST << token::END_STATEMENT << nl;
    }

public:

    TypeName("superficialInletVelocity");

    superficialInletVelocityFvPatchVectorField(const fvPatch& p, const DimensionedField<vector, volMesh>& iF)
    :
        fixedValueFvPatchVectorField(p, iF),
        voidageName_("voidage"),
        tables_(1, Table(1, Tuple2<scalar, scalar>(0, 0)))
    {}

    // At time zero, where no voidage is known yet, `value` is what the table says over a voidage of 1: the one in the
    // deck is for tools that do not know this condition.
    superficialInletVelocityFvPatchVectorField
    (
        const fvPatch& p, const DimensionedField<vector, volMesh>& iF, const dictionary& dict
    )
    :
        fixedValueFvPatchVectorField(p, iF, dict),
        voidageName_(dict.lookupOrDefault<word>("voidage", "voidage"))
    {
        readTables(dict);
        if (db().time().value() == 0) fvPatchVectorField::operator==(-velocities()*p.nf());
    }

    superficialInletVelocityFvPatchVectorField
    (
        const superficialInletVelocityFvPatchVectorField& other,
        const fvPatch& p, const DimensionedField<vector, volMesh>& iF, const fvPatchFieldMapper& mapper
    )
    :
        fixedValueFvPatchVectorField(other, p, iF, mapper),
        voidageName_(other.voidageName_),
        tables_(other.tables_),
        shares_(other.shares_.size())
    {
        forAll(shares_, k) shares_[k] = scalarField(other.shares_[k], mapper);
    }

    superficialInletVelocityFvPatchVectorField(const superficialInletVelocityFvPatchVectorField& other)
    :
        fixedValueFvPatchVectorField(other),
        voidageName_(other.voidageName_),
        tables_(other.tables_),
        shares_(other.shares_)
    {}

    superficialInletVelocityFvPatchVectorField
    (
        const superficialInletVelocityFvPatchVectorField& other, const DimensionedField<vector, volMesh>& iF
    )
    :
        fixedValueFvPatchVectorField(other, iF),
        voidageName_(other.voidageName_),
        tables_(other.tables_),
        shares_(other.shares_)
    {}

    virtual tmp<fvPatchVectorField> clone() const
    {
        return tmp<fvPatchVectorField>(new superficialInletVelocityFvPatchVectorField(*this));
    }

    virtual tmp<fvPatchVectorField> clone(const DimensionedField<vector, volMesh>& iF) const
    {
        return tmp<fvPatchVectorField>(new superficialInletVelocityFvPatchVectorField(*this, iF));
    }

    virtual void autoMap(const fvPatchFieldMapper& mapper)
    {
        fixedValueFvPatchVectorField::autoMap(mapper);
        for (scalarField& share : shares_) share.autoMap(mapper);
    }

    virtual void rmap(const fvPatchVectorField& field, const labelList& addressing)
    {
        fixedValueFvPatchVectorField::rmap(field, addressing);
        const auto& other = refCast<const superficialInletVelocityFvPatchVectorField>(field);
        forAll(shares_, k) shares_[k].rmap(other.shares_[k], addressing);
    }

    label streams() const { return tables_.size(); }

    // The part of stream k in the superficial velocity of each face, inwards.
    tmp<scalarField> velocities(const label k) const
    {
        const scalar now = velocity(tables_[k], db().time().value());
        if (shares_.empty()) return tmp<scalarField>(new scalarField(size(), now));
        return now*shares_[k];
    }

    // Other times and velocities from now on, of as many inlets as before.
    void setTables(const List<Table>& tables)
    {
        if (tables.size() != tables_.size())
        {
            FatalErrorInFunction
                << "patch " << patch().name() << " has " << tables_.size() << " tables, " << tables.size() << " are given"
                << exit(FatalError);
        }
        tables_ = tables;
    }

    virtual void updateCoeffs()
    {
        if (updated()) return;
        const fvPatchScalarField& voidage = patch().lookupPatchField<volScalarField, scalar>(voidageName_);
        fvPatchVectorField::operator==(-velocities()*patch().nf()/voidage);
        fixedValueFvPatchVectorField::updateCoeffs();
    }

    virtual void write(Ostream& os) const
    {
        fvPatchVectorField::write(os);
        os.writeEntry("voidage", voidageName_);
        if (shares_.empty()) writeTable(os, "table", tables_[0]);
        forAll(shares_, k)
        {
            writeTable(os, number("table", k), tables_[k]);
            shares_[k].writeEntry(number("share", k), os);
        }
        writeEntry("value", os);
    }
};

makePatchTypeField(fvPatchVectorField, superficialInletVelocityFvPatchVectorField);

}

Foam::tmp<Foam::scalarField> fbcouple::streamVelocity(const fvPatchVectorField& inlet, const label k)
{
    const auto& streams = refCast<const superficialInletVelocityFvPatchVectorField>(inlet);
    if (k < streams.streams()) return streams.velocities(k);
    FatalErrorInFunction
        << "patch " << inlet.patch().name() << " has " << streams.streams() << " tables, number " << k + 1
        << " has a temperature" << exit(FatalError);
    return tmp<scalarField>();
}

// The inlet of a gas that goes on from saved fields follows `tables` from now on. Where it had OpenFOAM's own condition,
// of one velocity, it gets the one above, with the velocity that it has.
void fbcouple::Gas::setInlet(const List<Table>& tables)
{
    typedef superficialInletVelocityFvPatchVectorField Inlet;
    const label patchi = mesh_.boundaryMesh().findPatchID("inlet");
    volVectorField::Boundary& boundary = U_.boundaryFieldRef();
    if (!isA<Inlet>(boundary[patchi]))
    {
        Inlet* inlet = new Inlet(mesh_.boundary()[patchi], U_.internalField());
        static_cast<fvPatchVectorField&>(*inlet) == boundary[patchi];
        boundary.set(patchi, inlet);
    }
    refCast<Inlet>(boundary[patchi]).setTables(tables);
}
