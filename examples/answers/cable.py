"""The tension at the ends of a hanging cable: ten links of 1 m and 2 kg a joint, over a gap of 8 m."""
import numpy
import tanor

positions = numpy.zeros((11, 3))
positions[:, 0] = numpy.linspace(0, 8, 11)
system = tanor.System(positions, 2.0, supports=[tanor.Support([0, 10])], forces=[tanor.Gravity((0, 0, -9.81))],
                      constraints=[tanor.Rods([[k, k + 1] for k in range(10)], length=1.0, name="links")], units="si")
rest = tanor.find_equilibrium(system)
tension = rest["links"].tension
print(f"{tension[0]:.10g} N at the ends, {tension[4]:.10g} N in the middle")
