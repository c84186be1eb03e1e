"""What results.nc may hold: names, units and meaning."""

from __future__ import annotations

STAGES = ("dem", "cfd", "map", "drag", "react", "average", "record", "wait")

# name -> unit, long name
MEANS: dict[str, tuple[str, str]] = {
    "solids_fraction": ("1", "time-mean solids fraction"),
    "solids_flux": ("kg m-2 s-1", "time-mean solids mass flux"),
    "solids_velocity": ("m s-1", "time-mean solids velocity, mass weighted"),
    "agitation": ("m2 s-2", "mean square of the particle velocity about the time mean"),
    "granular_temperature": ("m2 s-2", "third of the mean square particle velocity about the instantaneous cell mean"),
    "voidage": ("1", "time-mean voidage that the gas had"),
    "gas_velocity": ("m s-1", "time-mean interstitial gas velocity"),
    "gas_flux": ("m s-1", "time-mean superficial gas velocity, voidage times velocity"),
    "pressure": ("Pa", "time-mean dynamic pressure"),
    "gas_temperature": ("K", "time-mean temperature of the gas, weighted by voidage"),
    "solids_temperature": ("K", "time-mean temperature of the particles, weighted by mass"),
}
HISTORIES: dict[str, tuple[str, str]] = {
    "bed_height": ("m", "height above the floor of the uppermost layer whose mean solids fraction exceeds 0.2"),
    "pressure_drop": (
        "Pa",
        "dynamic pressure at the inlet against the outlet, mean since the last row (none at the start)",
    ),
    "averages_start": (
        "s",
        "begin of the time means, where the run finds it itself; none while the start-up is not seen to be over",
    ),
    "averages_error": (
        "1",
        "standard error of the mean averages.error_of over the mean, of maps root mean square; none before it is known",
    ),
    "expected_end": ("s", "time at which the means are expected to have the error averages.until_error"),
    "inlet_velocity": (
        "m s-1",
        "superficial velocity of the gas that came in by the inlet, mean since the last row; of ramps only",
    ),
    "gas_support": ("1", "upward force of the gas over the weight of the particles, mean since the last row"),
    "solids_volume": ("m3", "solids volume that the gas sees"),
    "solids_centre_z": ("m", "height of the particles' centre of mass above the floor"),
    "particles": ("1", "number of particles"),
    "particles_fed": ("1", "particles that came in by feeds up to now"),
    "particles_removed": ("1", "particles that left by outlets up to now"),
    "particles_owed": ("1", "particles that are due and wait for a free place in their feed"),
    "mass_fed": ("kg", "mass that came in by feeds up to now"),
    "mass_removed": ("kg", "mass that left by outlets up to now"),
    "heat_fed": ("J", "heat m c T that particles had as they came in, up to now"),
    "heat_removed": ("J", "heat m c T that particles had as they left, up to now"),
    "ledger_error": (
        "1",
        "particles that came and went against those that there are: missing ones, and the part of mass or momentum",
    ),
    "momentum_error": ("1", "largest imbalance of a step over its impulse since the last row"),
    "kinetic_energy": ("J", "kinetic energy of the particles' translation"),
    "gas_mass_error": (
        "1",
        "gas volume lost by continuity in a step, largest since the last row, over what the fastest inlet velocity "
        "brings in that time; where nothing ever comes in, over all the gas",
    ),
    "gas_inflow_error": (
        "1",
        "superficial velocity at the inlet against the case's, farthest off since the last row, over the fastest one",
    ),
    "displaced_gas_error": (
        "1",
        "gas volume that coupling steps not as long as the one before displaced too much or too little, added up cell "
        "by cell since the last row, over the solids volume",
    ),
    "gas_flux_error": (
        "1",
        "gas flux at a height (in a mesh of polyhedra: at the outlet) against continuity, farthest off, over the "
        "fastest inflow",
    ),
    "gas_backflow": (
        "1",
        "gas that came in by the outlets, over all that passed them, in and out, since the last row",
    ),
    "particles_at_outlet": ("1", "particles within a radius of the outlet, which is a wall for them"),
    "max_courant": ("1", "largest Courant number since the last row"),
    "min_voidage": ("1", "least voidage of a cell"),
    "cells_over_packed": ("1", "cells with a solids fraction above 0.74, the closest packing of equal spheres"),
    "max_overlap": ("1", "largest overlap of two particles over their mean diameter"),
    "substeps": ("1", "DEM steps in the last fluid step"),
    "mean_gas_temperature": ("K", "mean temperature of the gas, over its volume"),
    "mean_particle_temperature": ("K", "mean temperature of the particles, over their mass"),
    "min_temperature": ("K", "least temperature of a cell of gas or of a particle"),
    "max_temperature": ("K", "largest temperature of a cell of gas or of a particle"),
    "heat_given": ("W", "heat from the gas to the particles, mean since the last row"),
    "heat_by_walls": ("W", "heat that came to the gas by walls, mean since the last row"),
    "heat_by_inlets": (
        "W",
        "heat that came in by inlets, counted from heat.gas_temperature, mean since the last row",
    ),
    "heat_by_outlets": ("W", "heat that came in by outlets, counted in the same way, mean since the last row"),
    "heat_by_contacts": ("W", "heat that came to the particles by contacts with walls, mean since the last row"),
    "heat_by_continuity": ("W", "heat that errors of the gas' continuity made, mean since the last row"),
    "heat_error": ("1", "largest error of a step's ledger of heat over the heat held, since the last row"),
}


HISTORY_VECTORS: dict[str, tuple[str, str]] = {
    "momentum_fed": ("kg m s-1", "momentum that particles had as they came in, up to now"),
    "momentum_removed": ("kg m s-1", "momentum that particles had as they left, up to now"),
}
HISTORIES_OF_SPECIES: dict[str, tuple[str, str]] = {
    "species_centre_z": ("m", "height of the centre of mass of each species above the floor; of mixtures only"),
}
HISTORIES_OF_OUTLETS: dict[str, tuple[str, str]] = {
    "outlet_backflow": (
        "1",
        "gas that came in by each outlet, over all that passed it, in and out, since the last row; of several only",
    ),
}
EXITS: dict[str, tuple[str, str]] = {
    "number": ("1", "number of a particle that left"),
    "entry_time": ("s", "time at which a particle that left had come in; 0 of those of the start"),
    "feed": ("1", "feed by which a particle that left had come in, counted from 1; 0: it was there at the start"),
    "time": ("s", "time at which a particle left"),
    "outlet": ("1", "outlet by which a particle left, counted from 1"),
    "mass": ("kg", "mass of a particle, or parcel, that left"),
}
"""Of each particle that left, in the order of leaving: variables `exit_...` over the dimension `exit`."""
