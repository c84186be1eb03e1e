// The C interface to the gas of this process.
//
// Every function returns 0, or 1 with the reason in gas_error(). Arrays are the caller's; nothing keeps a pointer,
// because OpenFOAM's field storage moves at every assignment.

#include <cstdint>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <string>

#include "gas.hpp"

namespace
{

// Never destroyed: OpenFOAM's own end of a parallel run would finalise the MPI that mpi4py started.
fbcouple::Gas* gas = nullptr;
std::ofstream* logFile = nullptr;
std::string reason;

}

const Foam::fvMesh& gasMesh() { return gas->mesh(); }

int guarded(const std::function<void()>& action)
{
    try
    {
        action();
        return 0;
    }
    catch (const Foam::error& err)
    {
        reason = err.message();
    }
    catch (const std::exception& err)
    {
        reason = err.what();
    }
    return 1;
}

extern "C"
{

const char* gas_error() { return reason.c_str(); }

int gas_open(int argc, char** argv, const char* logName, double rho, int correctors)
{
    return guarded([&]
    {
        if (gas) throw std::runtime_error("one gas a process");
        logFile = new std::ofstream(logName);
        std::cout.rdbuf(logFile->rdbuf());
        std::cerr.rdbuf(logFile->rdbuf());
        Foam::FatalError.throwExceptions();
        Foam::FatalIOError.throwExceptions();
        gas = new fbcouple::Gas(argc, argv, rho, correctors);
        Foam::solverPerformance::debug = 0;
    });
}

const char* gas_time_name()
{
    static std::string name;
    name = gas->timeName();
    return name.c_str();
}

int64_t gas_cell_count() { return gas->nCells(); }
int gas_cells(double* centres, double* volumes) { return guarded([&] { gas->cells(centres, volumes); }); }

// `lengths`: rows of each of `count` tables; `rows`: their times and velocities, one after the other.
int gas_set_inlet(int count, const int64_t* lengths, const double* rows)
{
    return guarded([&]
    {
        Foam::List<fbcouple::Table> tables(count);
        forAll(tables, k)
        {
            tables[k].resize(lengths[k]);
            for (auto& row : tables[k])
            {
                row.first() = *rows++;
                row.second() = *rows++;
            }
        }
        gas->setInlet(tables);
    });
}

// After the heat was opened: the density is rho at `temperature` [K] and follows it; `gravity` [m/s2] downwards.
int gas_expand(double temperature, double gravity)
{
    return guarded([&] { gas->expand(temperature, gravity); });
}

int gas_start(const double* voidage) { return guarded([&] { gas->start(voidage); }); }
int gas_step(double dt, double moved, const double* voidage, const double* drag)
{
    return guarded([&] { gas->step(dt, moved, voidage, drag); });
}
int gas_fields(double* state, double* pressure, double* voidage, double* totals)
{
    return guarded([&] { gas->fields(state, pressure, voidage, totals); });
}
int gas_measure(double* values) { return guarded([&] { gas->measure(values); }); }
int gas_outlets(double* values) { return guarded([&] { gas->outlets(values); }); }
int gas_write() { return guarded([&] { gas->write(); }); }

}
