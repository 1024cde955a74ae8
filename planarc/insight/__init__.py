"""The structure, energy and motion of a mechanism, beyond the values of its variables.

    module      takes                        gives
    ---------   --------------------------   ---------------------------------------
    topology    Dae                          Mechanism: links, joints, mobility by count
    rank        Program, Kernel, Result      the rank of the conditions, dead points
    energy      Mechanism, Result            kinetic, potential, dissipated energy
    losses      Result                       energy lost by the integrator
    kinematics  Mechanism, Result            paths, forces, velocities, instant centres
    facts       all of these                 rows for people

`study.study(result)` calls them in a row. Of components they know what these declare
(`annotation(__planarc(...))`) and what their connectors hold, but no class and no variable.
"""
