"""The torque of a motor that turns the crank (1 m, 2 rad/s) of a four-bar linkage; 3 kg stand at the rocker's end."""
import tanor

rocker = (2.6875, (6.25 - 0.3125**2)**0.5, 0)  # 3 m from the crank's end, 2.5 m from its own hinge
system = tanor.System([(1, 0, 0), (3, 0, 0), rocker], 3.0, forces=[tanor.Gravity((0, -9.81, 0))], units="si",
                      supports=[tanor.Support(0, displacement=("cos(2*t)-1", "sin(2*t)", 0), name="crank"),
                                tanor.Support(1)],
                      constraints=[tanor.Rods([[0, 2], [1, 2]], name="bars")])
motor = tanor.Simulation(system, rtol=1e-12, start="project")
motor.add_observable("moment(crank, z, [0, 0, 0])", name="torque", every_step=True)
run = tanor.run(motor, 3.14, every=0.01)
largest = motor.observe()[-1].largest[0]
print(f"torque {run['torque'][0]:.10g} {run.units['torque']} at the start,",
      f"largest {largest.value:.10g} at t = {largest.time:.10g} s")
