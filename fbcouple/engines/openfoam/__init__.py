"""Stock OpenFOAM as the gas solver: a C++ adapter on its operators, loaded by ctypes."""
